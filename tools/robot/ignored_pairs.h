// SPDX-License-Identifier: GPL-3.0-or-later
// Pairs of links whose spheres need no check against each other, with proof: neighbours, pairs that touch in every
// configuration within the joint limits, and pairs that touch in none.
#pragma once

#include <vector>

#include "robot/robot_cover.h"

namespace spheretree::robot {

enum class PairReason {
  Adjacent,  // joined, with nothing but links without spheres between them
  Always,    // spheres of the two overlap in every configuration
  Never      // no two spheres of them touch in any configuration
};

struct IgnoredPair {
  std::size_t a, b;  // links, a < b
  PairReason reason;
};

struct PairSearch {
  std::size_t most_boxes = 20'000;  // of joint positions that are looked at for one pair; then it is left undecided
};

/// By link a, then b. A pair that is neither is not listed, and so is one with a floating or planar joint between, or
/// whose proof takes too long. The proof is about the spheres as they are written.
/// Method: branch and bound over boxes of joint positions. Within a box no sphere moves farther against the other link
///         than the sum, over the joints between, of half the box times the reach of that joint; so the gaps at its
///         middle, less that, hold in all of it.
/// Cost: for each pair up to most_boxes times the product of its numbers of spheres, about 2 ns each.
/// @throws builder::Cancelled
std::vector<IgnoredPair> findIgnoredPairs(const Robot& robot, const RobotCover& cover, const PairSearch& search,
                                          builder::Progress& progress);

}  // namespace spheretree::robot
