// SPDX-License-Identifier: GPL-3.0-or-later
// The space that a spinning burr sweeps: the union of capsules, one for each ball and each step.
// Units: mm, frame of the object that is cut.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace spheretree::builder {

/// The centres of a ball at the ends of consecutive steps in which the burr spun; two or more.
struct BurrPath {
  double radius = 0;  // > 0
  std::vector<Eigen::Vector3d> centres;
};

struct Capsule {
  Eigen::Vector3d from, to;
  double radius;
};

/// The nearest point of the axis of a capsule.
Eigen::Vector3d nearestOnAxis(const Capsule& capsule, const Eigen::Vector3d& p);

/// The capsules of all steps. If `slack` is above 0, steps in a row become one capsule where their centres are within
/// `slack` of its axis: the union of the capsules grown by `slack` then contains the swept space, and their union
/// shrunk by `slack` is contained in it. Cost: O(centres), times the steps in a capsule.
std::vector<Capsule> sweptCapsules(std::span<const BurrPath> paths, double slack);

}  // namespace spheretree::builder
