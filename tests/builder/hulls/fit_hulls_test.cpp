// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/fit_hulls.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "certify/triangle_piece.h"
#include "hulls/hull_cover.h"
#include "hulls/hull_overhang.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

std::vector<Hull> fit(const TriangleMesh& mesh, double tolerance, std::size_t max_hulls) {
  Progress progress;
  return fitHulls(mesh, DistanceField(mesh), {.tolerance = tolerance, .rounding = 1e-6, .max_hulls = max_hulls}, progress);
}

// What the fit returns is a cover within the tolerance: proven here, as the builder does later.
TEST(FitHulls, CoverWithinTheTolerance) {
  const TriangleMesh torus = test::torusMesh(3, 1, 24, 12);
  const std::vector<Hull> hulls = fit(torus, 0.15, 60);
  ASSERT_FALSE(hulls.empty());
  const HullCover cover(hulls, 1e-9);
  for (std::size_t t = 0; t < torus.triangles.size(); ++t)
    ASSERT_TRUE(cover.holds(pieceOf(torus, t, Eigen::Vector3d::Zero()))) << "triangle " << t;
  for (const Hull& hull : hulls) EXPECT_LE(hullOverhang(DistanceField(torus), hull, {.relative = 1e-3}).bound, 0.15 * (1 + 2e-3));
}

// A rod along a path with half balls at its ends: `radius` at the start, `end` at the other.
TriangleMesh rodMesh(const std::vector<Eigen::Vector3d>& path, double radius, double end) {
  constexpr std::uint32_t kAround = 64, kCap = 12;
  TriangleMesh mesh;
  const auto last = path.size() - 1;
  const auto addRing = [&](const Eigen::Vector3d& c, const Eigen::Vector3d& along, double r) {
    const Eigen::Vector3d v = Eigen::Vector3d::UnitY(), u = v.cross(along);  // the path lies in the xz plane
    for (std::uint32_t k = 0; k < kAround; ++k)
      mesh.positions.push_back(c +
                               r * (std::cos(2 * std::numbers::pi * k / kAround) * u + std::sin(2 * std::numbers::pi * k / kAround) * v));
  };
  const auto tangent = [&](std::size_t i) { return (path[std::min(i + 1, last)] - path[i == 0 ? 0 : i - 1]).normalized(); };
  for (std::uint32_t k = 1; k < kCap; ++k) {
    const double a = std::numbers::pi / 2 * (1 - static_cast<double>(k) / kCap);
    addRing(path[0] - radius * std::sin(a) * tangent(0), tangent(0), radius * std::cos(a));
  }
  for (std::size_t i = 0; i <= last; ++i)
    addRing(path[i], tangent(i), radius + (end - radius) * static_cast<double>(i) / static_cast<double>(last));
  for (std::uint32_t k = 1; k < kCap; ++k) {
    const double a = std::numbers::pi / 2 * k / kCap;
    addRing(path[last] + end * std::sin(a) * tangent(last), tangent(last), end * std::cos(a));
  }
  const auto rings = static_cast<std::uint32_t>(mesh.positions.size() / kAround), low = rings * kAround, high = low + 1;
  mesh.positions.push_back(path[0] - radius * tangent(0));
  mesh.positions.push_back(path[last] + end * tangent(last));
  for (std::uint32_t k = 0; k < kAround; ++k) {
    const std::uint32_t next = (k + 1) % kAround, top = (rings - 1) * kAround;
    mesh.triangles.push_back({low, next, k});
    mesh.triangles.push_back({high, top + k, top + next});
    for (std::uint32_t r = 0; r + 1 < rings; ++r) {
      const std::uint32_t a = r * kAround, b = a + kAround;
      mesh.triangles.push_back({a + k, a + next, b + next});
      mesh.triangles.push_back({a + k, b + next, b + k});
    }
  }
  return mesh;
}

TEST(FitHulls, FewForATaperedRod) {
  std::vector<Eigen::Vector3d> path;
  for (int i = 0; i <= 20; ++i) path.emplace_back(0, 0, i);
  const std::vector<Hull> hulls = fit(rodMesh(path, 1.0, 0.5), 0.02, 60);
  EXPECT_GE(hulls.size(), 1u);
  EXPECT_LE(hulls.size(), 3u);
}

// A cone along an arc of radius R is off by s = l^2 / (8 R) in its middle, and s is at most the tolerance if its balls
// lie beyond the axis by half of that: at least length / sqrt(8 R t) cones.
TEST(FitHulls, AnArcTakesLittleMoreThanItsSagAllows) {
  constexpr double kRadius = 10, kTolerance = 0.02, kAngle = 1;
  std::vector<Eigen::Vector3d> path;
  for (int i = 0; i <= 60; ++i) path.push_back({kRadius * (1 - std::cos(kAngle * i / 60)), 0, kRadius * std::sin(kAngle * i / 60)});
  const std::vector<Hull> hulls = fit(rodMesh(path, 0.6, 0.6), kTolerance, 60);
  const double fewest = kRadius * kAngle / std::sqrt(8 * kRadius * kTolerance);
  EXPECT_GE(static_cast<double>(hulls.size()), std::floor(fewest));
  EXPECT_LE(static_cast<double>(hulls.size()), 1.7 * fewest);
  // Neighbours share a centre, so that the chain is felt as one curve.
  std::size_t ends = 0, shared = 0;
  for (const Hull& hull : hulls)
    for (std::size_t k = 0; k < hull.count; ++k, ++ends)
      shared += std::ranges::any_of(hulls, [&](const Hull& other) {
        return &other != &hull && std::any_of(other.ball.begin(), other.ball.begin() + static_cast<std::ptrdiff_t>(other.count),
                                              [&](const Ball& b) { return b.centre == hull.ball[k].centre; });
      });
  EXPECT_GE(shared + 4, ends);
}

TEST(FitHulls, TheSameHullsForAnyNumberOfThreads) {
  const TriangleMesh torus = test::torusMesh(3, 1, 24, 12);
  const std::vector<Hull> hulls = fit(torus, 0.15, 60);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const std::vector<Hull> again = fit(torus, 0.15, 60);
  ASSERT_EQ(hulls.size(), again.size());
  for (std::size_t i = 0; i < hulls.size(); ++i)
    for (std::size_t k = 0; k < hulls[i].count; ++k) {
      EXPECT_EQ(hulls[i].ball[k].centre, again[i].ball[k].centre);
      EXPECT_EQ(hulls[i].ball[k].radius, again[i].ball[k].radius);
    }
}

// Too few samples, or no ball that deep: a smaller tolerance, or a ball that is less deep, takes its place.
TEST(FitHulls, AToleranceBeyondTheThicknessIsMetAsWell) {
  for (const TriangleMesh& mesh : {test::torusMesh(3, 1, 24, 12), test::quartered(test::boxMesh({0, 0, 0}, {20, 12, 0.5}))})
    for (const double tolerance : {0.3, 1.0, 3.0, 50.0}) {
      const std::vector<Hull> hulls = fit(mesh, tolerance, 200);
      ASSERT_FALSE(hulls.empty()) << tolerance;
      for (const Hull& hull : hulls) EXPECT_LE(hullOverhang(DistanceField(mesh), hull, {.relative = 1e-3}).bound, tolerance * (1 + 2e-3));
    }
}

TEST(FitHulls, NoneIfTheNumberDoesNotSuffice) { EXPECT_TRUE(fit(test::torusMesh(3, 1, 24, 12), 0.15, 3).empty()); }

}  // namespace
}  // namespace spheretree::builder
