// SPDX-License-Identifier: GPL-3.0-or-later
#include "repair/fill_holes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "support/mesh_measures.h"
#include "support/shapes.h"
#include "support/soup.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
using test::boxMesh;
using test::soupOf;

const Progress kUnwatched;

TEST(FillHoles, LeavesNoEdgeOpen) {
  std::mt19937_64 random(4);
  for (int round = 0; round < 20; ++round) {
    RepairWork work(kUnwatched);
    RepairSoup soup = soupOf(test::sphereMesh(1, 3));
    const std::size_t share = 2 + random() % 20;  // between half of the triangles and one in 21: loops that meet in vertices
    std::erase_if(soup.mesh.triangles, [&](const Triangle&) { return random() % share == 0; });
    soup.source.resize(soup.mesh.triangles.size());
    const std::size_t open = findOpenEdges(soup.mesh).size();
    std::size_t filled = 0;
    for (const FilledHole& hole : fillHoles(soup, work)) filled += hole.edges;
    EXPECT_EQ(filled, open);
    EXPECT_TRUE(findOpenEdges(soup.mesh).empty());
    EXPECT_EQ(soup.source.size(), soup.mesh.triangles.size());
  }
}

TEST(FillHoles, FromTheMiddleWhereThereAreTooManyEdges) {
  RepairWork work(kUnwatched);
  RepairSoup soup = soupOf(boxMesh({0, 0, 0}, {1, 1, 1}));
  soup.mesh.triangles.erase(soup.mesh.triangles.begin(), soup.mesh.triangles.begin() + 2);  // the bottom
  soup.source.resize(10);
  const auto holes = fillHoles(soup, work, 3);
  ASSERT_EQ(holes.size(), 1u);
  EXPECT_EQ(holes[0].triangles.size(), 4u);
  EXPECT_NEAR(holes[0].length, 4, 1e-12);
  EXPECT_NEAR(test::volumeOf(soup.mesh), 1, 1e-12);
}

TEST(FillHoles, SpansAFlatBorderByItsArea) {
  TriangleMesh pyramid;  // over a star of seven points: the filling of its bottom is the star
  double area = 0;
  constexpr std::uint32_t kCorners = 14;
  for (std::uint32_t i = 0; i < kCorners; ++i) {
    const double angle = 2 * std::numbers::pi * i / kCorners, r = i % 2 ? 1 : 2.5;
    pyramid.positions.emplace_back(r * std::cos(angle), r * std::sin(angle), 0);
    area += 0.5 * 1 * 2.5 * std::sin(2 * std::numbers::pi / kCorners);
  }
  pyramid.positions.emplace_back(0, 0, 3);
  for (std::uint32_t i = 0; i < kCorners; ++i) pyramid.triangles.push_back({i, (i + 1) % kCorners, kCorners});
  RepairWork work(kUnwatched);
  RepairSoup soup = soupOf(pyramid);
  const auto holes = fillHoles(soup, work);
  ASSERT_EQ(holes.size(), 1u);
  EXPECT_EQ(holes[0].triangles.size(), kCorners - 2u);
  EXPECT_NEAR(holes[0].across, std::hypot(2.5 + 2.5 * std::cos(std::numbers::pi / 7), 5 * std::sin(3 * std::numbers::pi / 7)), 0.3);
  EXPECT_NEAR(test::areaOf(soup.mesh) - test::areaOf(pyramid), area, 1e-12);
  EXPECT_NEAR(test::volumeOf(soup.mesh), area * 3 / 3, 1e-12);
}

// All vertices on one line: no triangulation is better than another, and the search for one takes O(n^3).
TEST(FillHoles, SpansADegenerateLoopInBoundedTime) {
  for (const std::uint32_t corners : {30u, 1200u}) {
    TriangleMesh needle;
    for (std::uint32_t i = 0; i < corners; ++i) needle.positions.emplace_back(std::min(i, corners - i), 0, 0);
    needle.positions.emplace_back(0, 1, 0);
    for (std::uint32_t i = 0; i < corners; ++i) needle.triangles.push_back({i, (i + 1) % corners, corners});
    RepairWork work(kUnwatched, 10'000'000);
    RepairSoup soup = soupOf(needle);
    const std::size_t open = findOpenEdges(soup.mesh).size();
    std::size_t added = 0;
    for (const FilledHole& hole : fillHoles(soup, work)) added += hole.triangles.size();
    EXPECT_LE(added, open);
    EXPECT_TRUE(findOpenEdges(soup.mesh).empty());
  }
  Progress cancelled;
  cancelled.cancel();
  RepairWork work(cancelled);
  RepairSoup soup = soupOf(boxMesh({0, 0, 0}, {1, 1, 1}));
  soup.mesh.triangles.pop_back(), soup.source.pop_back();
  EXPECT_THROW(fillHoles(soup, work), Cancelled);
}

}  // namespace
}  // namespace spheretree::builder
