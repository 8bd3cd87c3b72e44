// SPDX-License-Identifier: Apache-2.0
// A tool without bumps: the union of convex hulls of one, two or three balls, that is of balls, rounded cones and
// slabs. It covers the surface as the leaves do, and what a tool rests on is as smooth as it is.
//
// A hull is the union of the balls between its own: with weights w >= 0 of sum 1, the ball with the centre sum w_i c_i
// and the radius sum w_i r_i. The hulls are cut into *parts*, none of which is much longer than thick, so that a search
// over enclosing spheres is narrow. The parts are the corners, edges and faces of the hulls that can touch something:
// where two parts continue each other in one cone or slab, their common ball or cone is not a part of its own.
// Paper: P. Li, B. Wang, F. Sun, X. Guo, C. Zhang, W. Wang. Q-MAT: computing medial axis transform by quadratic error
//         minimization. ACM TOG 35(1), 2015, for hulls of two and three medial balls as primitives of a shape.
// Units: mm, frame of the tree.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "spheretree/core/search_tree.h"
#include "spheretree/core/sphere.h"

namespace spheretree {

inline constexpr std::uint16_t kNoHullBall = 0xffff;
/// The balls of a part: indices, different ones, then kNoHullBall.
using HullPart = std::array<std::uint16_t, 3>;

/// Largest sine of the half angle of a cone, and of the angle of a slab's faces with its plane. Beyond it, one ball
/// almost holds another, and the cone or slab is no more than its balls.
inline constexpr double kSteepestHull = 0.999;

struct Hulls {
  float overhang_bound = 0;     // proven: no point of a hull is farther outside the mesh [mm]
  std::uint32_t count = 0;      // number of hulls before they were cut
  std::vector<Sphere> balls;    // at most kNoHullBall
  std::vector<HullPart> parts;  // of one ball, then of two, then of three
  SearchTree search;            // over the parts

  bool empty() const { return parts.empty(); }
  friend bool operator==(const Hulls&, const Hulls&) = default;
};

/// Number of balls of a part: 1 to 3.
inline std::size_t ballCount(const HullPart& part) { return part[1] == kNoHullBall ? 1 : part[2] == kNoHullBall ? 2 : 3; }

/// A sphere that encloses the part. Deterministic.
Sphere enclose(const Hulls& hulls, const HullPart& part);

/// How steep the hull of two or three balls is: the sine of the half angle of a cone, or of the angle that the faces of
/// a slab make with the plane of its centres; 0 for one ball. Above 1: one ball holds the others. Infinite: two centres
/// coincide, or those of a slab lie on a line.
double steepness(std::span<const Ball> balls);
double steepness(const Hulls& hulls, const HullPart& part);

/// Returns a sentence about the first broken rule, which names the part, or "" for sound hulls. The rules: balls are
/// finite, with radii > 0; indices are in range and different; the parts are in order, and none is steeper than
/// kSteepestHull; every sphere of the search tree encloses the balls of the parts below it.
std::string findFault(const Hulls& hulls);

}  // namespace spheretree
