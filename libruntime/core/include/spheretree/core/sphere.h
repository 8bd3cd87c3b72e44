// SPDX-License-Identifier: Apache-2.0
// The sphere as files store it and as the runtime tests it, and the ball in double precision from which it is rounded.
#pragma once

#include <Eigen/Core>

namespace spheretree {

/// Centre and radius in the frame of the tree [mm]. 16 bytes, the layout of the file.
struct Sphere {
  float x, y, z;
  float radius;  // finite, > 0
  friend bool operator==(const Sphere&, const Sphere&) = default;
};
static_assert(sizeof(Sphere) == 16);

struct Ball {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // [mm]
  double radius = 0;                                 // [mm]
};

inline Eigen::Vector3d centreOf(const Sphere& s) { return {static_cast<double>(s.x), static_cast<double>(s.y), static_cast<double>(s.z)}; }

}  // namespace spheretree
