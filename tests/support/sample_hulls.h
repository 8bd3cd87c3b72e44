// SPDX-License-Identifier: Apache-2.0
// Tools of hulls with closed forms, made without the builder.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "spheretree/core/hulls.h"
#include "spheretree/core/rigid.h"
#include "support/sample_skins.h"
#include "support/shape_trees.h"

namespace spheretree::test {

inline Sphere ballAt(const Eigen::Vector3d& c, double radius) {
  return {static_cast<float>(c.x()), static_cast<float>(c.y()), static_cast<float>(c.z()), static_cast<float>(radius)};
}

/// These hulls with a search tree by halving.
inline Hulls hullsOf(std::vector<Sphere> balls, std::vector<HullPart> parts, std::uint32_t count) {
  Hulls hulls;
  hulls.count = count;
  hulls.balls = std::move(balls);
  hulls.parts = std::move(parts);
  std::ranges::stable_sort(hulls.parts, {}, ballCount);
  std::vector<Sphere> items;
  for (const HullPart& part : hulls.parts) items.push_back(enclose(hulls, part));
  hulls.search = searchTreeOf(items, 8);
  return hulls;
}

inline Hulls ballHull(double radius) { return hullsOf({ballAt({0, 0, 0}, radius)}, {{0, kNoHullBall, kNoHullBall}}, 1); }

/// A rounded cone from a to b, cut into pieces.
inline Hulls rodHulls(const Eigen::Vector3d& a, double radius_a, const Eigen::Vector3d& b, double radius_b, std::uint16_t pieces = 8) {
  std::vector<Sphere> balls;
  std::vector<HullPart> parts{{0, kNoHullBall, kNoHullBall}, {pieces, kNoHullBall, kNoHullBall}};
  for (std::uint16_t i = 0; i <= pieces; ++i) {
    const double share = i / static_cast<double>(pieces);
    balls.push_back(ballAt(a + share * (b - a), radius_a + share * (radius_b - radius_a)));
    if (i < pieces) parts.push_back({i, static_cast<std::uint16_t>(i + 1), kNoHullBall});
  }
  return hullsOf(balls, parts, 1);
}

/// A round plate in the plane z = 0, as a fan of `corners` slabs: the convex hull of balls on a circle of radius
/// `rim`, with half the thickness `half`.
inline Hulls discHulls(double rim, double half, std::uint16_t corners) {
  std::vector<Sphere> balls{ballAt({0, 0, 0}, half)};
  std::vector<HullPart> parts;
  for (std::uint16_t i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    balls.push_back(ballAt({rim * std::cos(angle), rim * std::sin(angle), 0}, half));
    const auto a = static_cast<std::uint16_t>(1 + i), b = static_cast<std::uint16_t>(1 + (i + 1) % corners);
    parts.push_back({a, kNoHullBall, kNoHullBall});
    parts.push_back({a, b, kNoHullBall});
    parts.push_back({0, a, b});
  }
  return hullsOf(balls, parts, corners);
}

/// A tool of these hulls, with their balls as leaves.
inline SphereTree toolOf(const Hulls& hulls) {
  SphereTree tree = treeOfBalls(hulls.balls);
  tree.hulls = hulls;
  return tree;
}

}  // namespace spheretree::test
