// SPDX-License-Identifier: GPL-3.0-or-later
#include "repair/resolve_overlaps.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "geometry/winding_number.h"
#include "spheretree/builder/mesh_checks.h"
#include "spheretree/core/mesh_edit.h"
#include "support/mesh_measures.h"
#include "support/shapes.h"
#include "support/soup.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
using test::boxMesh;
using test::soupOf;

constexpr OverlapLimits kNoLimits{100'000, 100'000};

// A row of boxes, each slightly rotated and pushed into the one before: the oracle of the union is a grid of points.
TEST(ResolveOverlaps, KeepsTheUnion) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  TriangleMesh all;
  struct Box {
    Eigen::Matrix3d turn;
    Vector3d middle;
  };
  std::vector<Box> boxes;
  for (int i = 0; i < 6; ++i) {
    const Eigen::Quaterniond turn = Eigen::Quaterniond(unit(random), unit(random), unit(random), unit(random)).normalized();
    boxes.push_back({turn.toRotationMatrix(), Vector3d(0.7 * i, unit(random) * 0.3, unit(random) * 0.3)});
    TriangleMesh box = boxMesh({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});
    const auto first = static_cast<std::uint32_t>(all.positions.size());
    for (const Vector3d& p : box.positions) all.positions.push_back(turn * p + boxes.back().middle);
    for (const auto& [a, b, c] : box.triangles) all.triangles.push_back({first + a, first + b, first + c});
  }
  RepairSoup soup = soupOf(all);
  Progress progress;
  RepairWork work(progress);
  const Resolved resolved = resolveOverlaps(soup, kNoLimits, 0, 0, progress, work);
  EXPECT_GT(resolved.crossing_pairs, 20u);
  EXPECT_EQ(resolved.lost_area, 0);
  EXPECT_TRUE(checkMesh(soup.mesh).clean()) << checkMesh(soup.mesh).summary();
  const WindingNumber winding(soup.mesh);
  std::uniform_real_distribution<double> x(-1, 4.5), y(-1.2, 1.2);
  int inside = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vector3d p(x(random), y(random), y(random));
    double depth = 1;  // distance to the union's boxes, a lower bound
    for (const Box& b : boxes)
      depth = std::min(depth, test::boxDistance({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}, b.turn.transpose() * (p - b.middle)));
    if (std::abs(depth) < 1e-3) continue;
    inside += depth < 0;
    ASSERT_NEAR(winding.at(p), depth < 0 ? 1 : 0, 0.1) << p.transpose();
  }
  EXPECT_GT(inside, 2000);
}

// Rectangles in one plane, cut identically on both sides for any ties of Delaunay: a wall of bricks of two sizes.
TEST(ResolveOverlaps, CutsCoplanarTrianglesAlike) {
  TriangleMesh all;
  const auto add = [&](const TriangleMesh& box) {
    const auto first = static_cast<std::uint32_t>(all.positions.size());
    all.positions.insert(all.positions.end(), box.positions.begin(), box.positions.end());
    for (const auto& [a, b, c] : box.triangles) all.triangles.push_back({first + a, first + b, first + c});
  };
  for (int i = 0; i < 4; ++i) add(boxMesh({0.5 * i, 0, 0}, {0.5 * i + 0.5, 1, 1}));
  for (int i = 0; i < 3; ++i) add(boxMesh({2.0 / 3 * i, 0, 1}, {2.0 / 3 * (i + 1), 1, 2}));
  RepairSoup soup = soupOf(all);
  Progress progress;
  RepairWork work(progress);
  resolveOverlaps(soup, kNoLimits, 0, 0, progress, work);
  EXPECT_TRUE(findOpenEdges(soup.mesh).empty());
  EXPECT_NEAR(test::volumeOf(soup.mesh), 4, 1e-12);
  EXPECT_NEAR(test::areaOf(soup.mesh), 2 * (2 * 2 + 2 * 1 + 2 * 1), 1e-12);
}

// An inverted box crosses a correct one: the volume with negative winding is not solid, unless that loses too much.
TEST(ResolveOverlaps, TreatsInvertedSolidsAsSolidIfTooMuchWouldBeLost) {
  TriangleMesh backwards = boxMesh({1, 0.25, 0.25}, {4, 0.75, 0.75});
  for (Triangle& t : backwards.triangles) std::swap(t[0], t[1]);
  const TriangleMesh all = joined(boxMesh({0, 0, 0}, {2, 1, 1}), backwards);
  Progress progress;
  RepairWork work(progress);
  RepairSoup kept = soupOf(all);
  const Resolved lost = resolveOverlaps(kept, kNoLimits, 0, 100, progress, work);
  EXPECT_FALSE(lost.is_either_way);
  EXPECT_NEAR(lost.lost_area, 4 * 2 * 0.5 + 2 * 0.25, 1e-12);  // of the part that reaches out, and of the wall through which it passes
  EXPECT_NEAR(test::volumeOf(kept.mesh), 2 - 0.25, 1e-12);
  RepairSoup whole = soupOf(all);
  const Resolved both = resolveOverlaps(whole, kNoLimits, 0, 1, progress, work);
  EXPECT_TRUE(both.is_either_way);
  EXPECT_EQ(both.lost_area, 0);
  EXPECT_NEAR(test::volumeOf(whole.mesh), 2 - 0.25 + 0.5, 1e-12);
}

TEST(ResolveOverlaps, StopsAtItsLimitsAndLeavesTheSoupAlone) {
  const TriangleMesh all = joined(boxMesh({0, 0, 0}, {2, 2, 2}), boxMesh({1, 1, 1}, {3, 3, 3}));
  RepairSoup soup = soupOf(all);
  Progress progress;
  RepairWork work(progress);
  EXPECT_TRUE(resolveOverlaps(soup, {3, 1000}, 0, 0, progress, work).is_stopped);
  EXPECT_TRUE(resolveOverlaps(soup, {1000, 30}, 0, 0, progress, work).is_stopped);
  RepairWork little(progress, 100);
  EXPECT_THROW(resolveOverlaps(soup, kNoLimits, 0, 0, progress, little), TooMuchWork);
  EXPECT_EQ(soup.mesh.triangles, all.triangles);
}

}  // namespace
}  // namespace spheretree::builder
