// SPDX-License-Identifier: GPL-3.0-or-later
#include "repair/repair_soup.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "spheretree/core/mesh_edit.h"
#include "support/mesh_measures.h"
#include "support/shapes.h"
#include "support/soup.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
using test::boxMesh;
using test::soupOf;

const Progress kProgress;

TEST(OpenEdges, AreThoseOfHolesAndOfClashes) {
  TriangleMesh box = boxMesh({0, 0, 0}, {1, 1, 1});
  EXPECT_TRUE(findOpenEdges(box).empty());
  std::swap(box.triangles[0][0], box.triangles[0][1]);
  ASSERT_EQ(findOpenEdges(box).size(), 3u);
  EXPECT_EQ(findOpenEdges(box)[0].times, 2);
  box.triangles.erase(box.triangles.begin());
  ASSERT_EQ(findOpenEdges(box).size(), 3u);
  EXPECT_EQ(findOpenEdges(box)[0].times, 1);
}

TEST(DropFlat, KeepsWhatHasAnArea) {
  TriangleMesh mesh = boxMesh({0, 0, 0}, {1, 1, 1});
  mesh.positions.push_back(0.5 * (mesh.positions[0] + mesh.positions[1]));
  mesh.triangles.insert(mesh.triangles.begin() + 3, {{0, 1, 8}, {2, 2, 5}});
  RepairSoup soup = soupOf(mesh);
  EXPECT_EQ(dropFlat(soup), (std::vector<std::uint32_t>{3, 4}));
  EXPECT_EQ(soup.mesh.triangles, boxMesh({0, 0, 0}, {1, 1, 1}).triangles);
  EXPECT_EQ(soup.source[3], 5u);
}

TEST(AlignWinding, AgreesWithTheLargerArea) {
  const TriangleMesh sphere = test::sphereMesh(1, 3);
  std::mt19937_64 random(1);
  for (const bool largest : {false, true}) {
    RepairSoup soup = soupOf(sphere);
    std::size_t turned = 0;
    for (Triangle& t : soup.mesh.triangles)
      if ((random() % 4 == 0) != largest) std::swap(t[0], t[1]), ++turned;
    EXPECT_EQ(alignWinding(soup), largest ? sphere.triangles.size() - turned : turned);
    EXPECT_NEAR(test::volumeOf(soup.mesh), (largest ? -1 : 1) * test::volumeOf(sphere), 1e-12);
    EXPECT_TRUE(findOpenEdges(soup.mesh).empty());
  }
}

TEST(TurnInward, TurnsBodiesButNoCavities) {
  const auto inward = [](TriangleMesh mesh) {
    for (Triangle& t : mesh.triangles) std::swap(t[0], t[1]);
    return mesh;
  };
  const TriangleMesh parts[] = {boxMesh({0, 0, 0}, {4, 4, 4}), inward(boxMesh({1, 1, 1}, {2, 2, 2})),
                                inward(boxMesh({9, 0, 0}, {10, 1, 2})), inward(boxMesh({3, 3, 3}, {5, 5, 5}))};
  TriangleMesh all;
  std::vector<std::uint32_t> component_of;
  for (std::uint32_t i = 0; i < 4; ++i) {
    all = joined(all, parts[i]);
    component_of.resize(all.triangles.size(), i);
  }
  RepairSoup soup = soupOf(all);
  RepairWork work(kProgress);
  EXPECT_EQ(turnInward(soup, component_of, work), 2u);
  EXPECT_NEAR(test::volumeOf(soup.mesh), 64 - 1 + 2 + 8, 1e-12);
  EXPECT_EQ(turnInward(soup, component_of, work), 0u);
}

TEST(AlignWinding, LeavesAMoebiusStripOneSided) {
  for (const bool is_twisted : {false, true}) {
    TriangleMesh strip;
    constexpr std::uint32_t kSteps = 12;
    for (std::uint32_t i = 0; i < kSteps; ++i) {
      const double u = 0.5236 * i, half = is_twisted ? u / 2 : 0;
      for (const double side : {-1.0, 1.0})
        strip.positions.emplace_back((4 + side * std::cos(half)) * std::cos(u), (4 + side * std::cos(half)) * std::sin(u),
                                     side * std::sin(half));
    }
    for (std::uint32_t i = 0; i < kSteps; ++i) {
      const std::uint32_t a = 2 * i, b = a + 1;
      const bool is_last = i + 1 == kSteps;
      const std::uint32_t c = is_last ? (is_twisted ? 1 : 0) : a + 2, d = is_last ? (is_twisted ? 0 : 1) : a + 3;
      strip.triangles.insert(strip.triangles.end(), {{a, c, b}, {b, c, d}});
    }
    RepairSoup soup = soupOf(strip);
    alignWinding(soup);
    EXPECT_EQ(isOneSided(soup.mesh), is_twisted);
  }
}

// A box, a wall of no thickness on it and three equal triangles: one of the three remains, and no edge is open, as
// before.
TEST(CancelOpposites, LeavesTheSumOfWindings) {
  const TriangleMesh box = boxMesh({0, 0, 0}, {1, 1, 1});
  const auto [a, b, c] = box.triangles[4];
  TriangleMesh mesh = box;
  mesh.positions.push_back({5, 5, 5});
  mesh.triangles.insert(mesh.triangles.end(), {{a, b, 8}, {b, a, 8}, {b, a, c}, {b, c, a}});
  RepairSoup soup = soupOf(mesh);
  const std::size_t open = findOpenEdges(mesh).size();
  EXPECT_EQ(cancelOpposites(soup), (std::vector<std::uint32_t>{4, 12, 13, 14}));
  EXPECT_EQ(soup.mesh.triangles.size(), 12u);
  EXPECT_EQ(findOpenEdges(soup.mesh).size(), open);
  EXPECT_NEAR(test::volumeOf(soup.mesh), 1, 1e-12);
  EXPECT_TRUE(cancelOpposites(soup).empty());
}

TEST(DropFins, KeepsLargeAndUnconnectedSheets) {
  const TriangleMesh sphere = test::sphereMesh(10, 3);
  for (const double height : {0.5, 12.0}) {
    TriangleMesh mesh = sphere;
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    const auto [a, b, c] = mesh.triangles[0];
    const Vector3d middle = 0.5 * (mesh.positions[a] + mesh.positions[b]);
    for (const Vector3d& p : {Vector3d(middle * (1 + height / 10)), Vector3d(12, 0, 0), Vector3d(12, 1, 0), Vector3d(12, 0, 1)})
      mesh.positions.push_back(p);
    mesh.triangles.push_back({a, b, first});
    mesh.triangles.push_back({first + 1, first + 2, first + 3});
    RepairSoup soup = soupOf(mesh);
    RepairWork work(kProgress);
    const std::vector<std::uint32_t> dropped = dropFins(soup, work);
    EXPECT_EQ(dropped, height < 1 ? std::vector{static_cast<std::uint32_t>(sphere.triangles.size())} : std::vector<std::uint32_t>());
    EXPECT_EQ(soup.mesh.triangles.size() + dropped.size(), mesh.triangles.size());
  }
}

// A long edge beside a border of many vertices: each of them would divide the triangle at the edge, and its neighbours
// again. The number of triangles stays within the limit.
TEST(StitchCracks, StaysWithinItsBounds) {
  constexpr std::uint32_t kVertices = 200, kLongEdges = 50;
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i <= kVertices; ++i) mesh.positions.emplace_back(i, 0, 0);
  mesh.positions.emplace_back(0.5 * kVertices, 50, 0);
  for (std::uint32_t i = 0; i < kVertices; ++i) mesh.triangles.push_back({i, i + 1, kVertices + 1});
  for (std::uint32_t i = 0; i < kLongEdges; ++i) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const double x : {-1.0 - i, kVertices + 1.0 + i}) mesh.positions.emplace_back(x, 0, 0);
    mesh.positions.emplace_back(0, -50, i);
    mesh.triangles.push_back({first + 1, first, first + 2});
  }
  const std::size_t read = mesh.triangles.size();
  RepairWork work(kProgress);
  RepairSoup bounded = soupOf(mesh);
  stitchCracks(bounded, read, 4 * read, work);
  EXPECT_LE(bounded.mesh.triangles.size(), 4 * read);
  RepairWork little(kProgress, 100);
  EXPECT_THROW(stitchCracks(bounded, read, 4 * read, little), TooMuchWork);
}

}  // namespace
}  // namespace spheretree::builder
