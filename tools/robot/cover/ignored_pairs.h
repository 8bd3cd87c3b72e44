// SPDX-License-Identifier: GPL-3.0-or-later
// Pairs of links whose spheres need not be checked against each other, with proof: neighbours, pairs that touch in
// every configuration within the joint limits, and pairs that never touch.
#pragma once

#include <vector>

#include "robot/cover/robot_cover.h"

namespace spheretree::robot {

enum class PairReason {
  Adjacent,  // connected, with only links without spheres between them
  Always,    // spheres of the two links overlap in every configuration
  Never      // no two of their spheres touch in any configuration
};

struct IgnoredPair {
  std::size_t a, b;  // links, a < b
  PairReason reason;
};

struct PairSearch {
  std::size_t max_boxes = 20'000;  // largest number of boxes of joint positions for one pair; beyond it the pair is left undecided
};

/// Sorted by link a, then b. Pairs of no reason are not listed, nor are pairs with a floating or planar joint in
/// between, or whose proof takes too long. The proof is about the spheres as they are written.
/// Method: branch and bound over boxes of joint positions. Within a box a sphere moves relative to the other link by at
///         most the sum, over the joints in between, of half the box times the reach of that joint. The gaps at the
///         middle of the box, less that motion, therefore hold in the whole box.
/// Cost: for each pair up to max_boxes times the product of its numbers of spheres, about 2 ns each.
/// @throws builder::Cancelled
std::vector<IgnoredPair> findIgnoredPairs(const Robot& robot, const RobotCover& cover, const PairSearch& search,
                                          builder::Progress& progress);

}  // namespace spheretree::robot
