// SPDX-License-Identifier: GPL-3.0-or-later
// Covers a capsule by equal balls in a row, with the exact overhang.
//
// Balls of radius r + h about the segment reach out of the capsule by exactly h, and the capsule needs each of its
// points within r of the segment in a ball: the tips lie in the outer balls if these are at most h from the ends, and
// the side between two balls at a distance s is covered if (s / 2)^2 + r^2 <= (r + h)^2. n balls therefore cover a
// segment of length 2 h + 2 (n - 1) sqrt(h^2 + 2 r h), and h is the root of a quadratic equation.
// Units: mm.
#pragma once

#include <cstddef>
#include <vector>

#include "robot/model/link_shape.h"

namespace spheretree::robot {

struct BallRow {
  std::vector<LinkBall> balls;
  double overhang = 0;  // exact up to rounding, rounded up [mm]
};

/// The row of `count` (>= 1) equal balls with the least overhang.
BallRow ballRow(const LinkCapsule& capsule, std::size_t count);

/// The smallest number of equal balls with at most this overhang (> 0), or `max_count` if it is smaller.
std::size_t ballsForOverhang(const LinkCapsule& capsule, double overhang, std::size_t max_count);

}  // namespace spheretree::robot
