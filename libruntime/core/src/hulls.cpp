// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/hulls.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "describe.h"
#include "search_tree_spheres.h"
#include "spheretree/core/smallest_enclosing_ball.h"

namespace spheretree {
namespace {

using Eigen::Vector3d;

std::string faultIn(const Hulls& hulls, const HullPart& part) {
  const std::size_t count = ballCount(part);
  for (std::size_t k = 0; k < 3; ++k) {
    if (k >= count ? part[k] != kNoHullBall : part[k] >= hulls.balls.size()) return "it has a ball that there is not";
    for (std::size_t j = 0; j < std::min(k, count); ++j)
      if (part[j] == part[k]) return "it has the same ball twice";
  }
  if (!(steepness(hulls, part) <= kSteepestHull)) return "one of its balls almost holds another, or its centres lie on a line";
  return "";
}

}  // namespace

Sphere enclose(const Hulls& hulls, const HullPart& part) {
  std::array<Sphere, 3> balls{};
  const std::size_t count = ballCount(part);
  for (std::size_t k = 0; k < count; ++k) balls[k] = hulls.balls[part[k]];
  return smallestEnclosing(std::span<const Sphere>(balls.data(), count));
}

double steepness(std::span<const Ball> balls) {
  if (balls.size() == 1) return 0;
  const Vector3d e1 = balls[1].centre - balls[0].centre;
  const double rise1 = balls[1].radius - balls[0].radius, none = std::numeric_limits<double>::infinity();
  if (balls.size() == 2) return e1.norm() > 0 ? std::abs(rise1) / e1.norm() : none;
  const Vector3d e2 = balls[2].centre - balls[0].centre, across = e1.cross(e2);
  const double rise2 = balls[2].radius - balls[0].radius, square = across.squaredNorm();
  // The gradient g of the radius over the plane: g . e1 = rise1, g . e2 = rise2.
  return square > 1e-12 * e1.squaredNorm() * e2.squaredNorm() ? (rise1 * e2.cross(across) + rise2 * across.cross(e1)).norm() / square
                                                              : none;
}

double steepness(const Hulls& hulls, const HullPart& part) {
  std::array<Ball, 3> balls;
  const std::size_t count = ballCount(part);
  for (std::size_t k = 0; k < count; ++k) balls[k] = {centreOf(hulls.balls[part[k]]), double{hulls.balls[part[k]].radius}};
  return steepness({balls.data(), count});
}

std::string findFault(const Hulls& hulls) {
  if (!std::isfinite(hulls.overhang_bound) || !(hulls.overhang_bound >= 0)) return "the bound of the overhang is not finite and >= 0";
  if (hulls.balls.size() > kNoHullBall) return "there are more than 65535 balls";
  for (std::size_t i = 0; i < hulls.balls.size(); ++i)
    if (!isFinite(hulls.balls[i])) return describe("ball %zu is not finite, or its radius is not above 0", i);
  if (!std::ranges::is_sorted(hulls.parts, {}, ballCount)) return "the parts are not in the order of their numbers of balls";
  for (std::size_t i = 0; i < hulls.parts.size(); ++i)
    if (const std::string why = faultIn(hulls, hulls.parts[i]); !why.empty()) return describe("part %zu: %s", i, why.c_str());
  if (std::string fault = findTopologyFault(hulls.search, hulls.parts.size()); !fault.empty()) return fault;
  return findSphereFault(hulls.search, [&](const Sphere& s, std::size_t part) {
    return std::ranges::all_of(hulls.parts[part],
                               [&](std::uint16_t ball) { return ball == kNoHullBall || reach(s, hulls.balls[ball]) <= s.radius; });
  });
}

}  // namespace spheretree
