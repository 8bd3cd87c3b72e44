// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/crossing_triangles.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <numbers>

#include "spheretree/core/mesh_edit.h"
#include "support/fan_of_slivers.h"
#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
using test::boxMesh;

/// Whether a segment pierces a triangle, in general position.
bool pierces(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const std::array<Eigen::Vector3d, 3>& t) {
  const auto side = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, const Eigen::Vector3d& d) {
    return (b - a).cross(c - a).dot(d - a) > 0;
  };
  if (side(t[0], t[1], t[2], p) == side(t[0], t[1], t[2], q)) return false;
  const bool s = side(p, q, t[0], t[1]);
  return side(p, q, t[1], t[2]) == s && side(p, q, t[2], t[0]) == s;
}

TEST(CrossingTriangles, AreThoseOfBruteForce) {
  test::Random random(7);
  std::size_t total = 0;
  for (int round = 0; round < 20; ++round) {
    TriangleMesh mesh;
    for (std::uint32_t t = 0; t < 60; ++t) {
      const Eigen::Vector3d at = random.inCube(3);
      for (int k = 0; k < 3; ++k) mesh.positions.push_back(at + random.inCube(1));
      mesh.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    if (round % 2)  // with shared corners, too
      for (std::uint32_t t = 3; t < 60; t += 3) mesh.triangles[t][0] = mesh.triangles[t - 3][0];
    std::vector<std::pair<std::uint32_t, std::uint32_t>> expected;
    for (std::uint32_t a = 0; a < 60; ++a) {
      for (std::uint32_t b = a + 1; b < 60; ++b) {
        const auto corners = [&](std::size_t t) { return std::array{mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)}; };
        const auto meets = [&](std::size_t first, std::size_t second) {
          for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t v = mesh.triangles[first][k], w = mesh.triangles[first][(k + 1) % 3];
            const Triangle& other = mesh.triangles[second];
            if (std::count(other.begin(), other.end(), v) + std::count(other.begin(), other.end(), w) > 0) continue;
            if (pierces(mesh.positions[v], mesh.positions[w], corners(second))) return true;
          }
          return false;
        };
        if (meets(a, b) || meets(b, a)) expected.emplace_back(a, b);
      }
    }
    EXPECT_EQ(findCrossingTriangles(mesh, 10000).pairs, expected) << round;
    total += expected.size();
  }
  EXPECT_GT(total, 200u);
}

TEST(CrossingTriangles, TouchOrFoldOntoEachOther) {
  const auto crossings = [](std::vector<Eigen::Vector3d> positions, std::vector<Triangle> triangles) {
    TriangleMesh mesh;
    mesh.positions = std::move(positions);
    mesh.triangles = std::move(triangles);
    return findCrossingTriangles(mesh, 100).pairs.size();
  };
  const Eigen::Vector3d o(0, 0, 0), x(4, 0, 0), y(0, 4, 0);
  EXPECT_EQ(crossings({o, x, y, {3, 3, 0}}, {{0, 1, 2}, {1, 3, 2}}), 0u);                             // side by side
  EXPECT_EQ(crossings({o, x, y, {1, 1, 0}}, {{0, 1, 2}, {2, 1, 3}}), 1u);                             // folded flat
  EXPECT_EQ(crossings({o, x, y, {1, 1, 1e-300}}, {{0, 1, 2}, {2, 1, 3}}), 0u);                        // almost
  EXPECT_EQ(crossings({o, x, y, {1, 1, 0}, {1, 1, 5}, {9, 9, 5}}, {{0, 1, 2}, {3, 4, 5}}), 1u);       // a corner touches
  EXPECT_EQ(crossings({o, x, y, {1, 1, 1e-300}, {1, 1, 5}, {9, 9, 5}}, {{0, 1, 2}, {3, 4, 5}}), 0u);  // almost
  EXPECT_EQ(crossings({o, x, y, {2, 2, 1}, {2, 2, -1}}, {{0, 1, 2}, {0, 3, 4}}), 1u);                 // shares a corner and cuts through
  EXPECT_EQ(crossings({o, x, y, {-2, -2, 1}, {-2, -2, -1}}, {{0, 1, 2}, {0, 3, 4}}), 0u);
}

TEST(CrossingTriangles, LeaveOutFlatOnesAndDuplicates) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {1, 1, -1}, {1, 1, 1}, {1, 1, 3}};
  mesh.triangles = {{0, 1, 2}, {2, 1, 0}, {3, 4, 5}, {0, 0, 1}};  // again and turned; a line through it; no third corner
  EXPECT_TRUE(isFlat(mesh, 2));
  EXPECT_TRUE(isFlat(mesh, 3));
  EXPECT_FALSE(isFlat(mesh, 0));
  EXPECT_TRUE(findCrossingTriangles(mesh, 100).pairs.empty());
  mesh.positions[5].x() = std::nextafter(1.0, 2.0);  // a sliver, and no longer in line
  EXPECT_FALSE(isFlat(mesh, 2));
  EXPECT_EQ(findCrossingTriangles(mesh, 100).pairs.size(), 2u);
}

TEST(CrossingTriangles, AreFoundAlongALargeMesh) {
  // Pairs that cross along a line, and one long triangle that pierces the first of each pair.
  constexpr std::uint32_t kPairs = 20000;
  TriangleMesh mesh;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> expected;
  mesh.positions = {{-10, 0, 0.05}, {kPairs + 10.0, 0, 0.05}, {kPairs + 10.0, 0.01, 0.05}};
  mesh.triangles = {{0, 1, 2}};
  const auto add = [&](std::initializer_list<Eigen::Vector3d> corners) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), corners);
    mesh.triangles.push_back({first, first + 1, first + 2});
  };
  for (std::uint32_t i = 0; i < kPairs; ++i) {
    const double x = (i * 7919u) % kPairs;
    add({{x, -0.2, -0.2}, {x, 0.2, -0.2}, {x, 0, 0.3}});
    add({{x - 0.2, -0.1, -0.1}, {x + 0.2, -0.1, -0.1}, {x, 0.3, -0.1}});
    expected.push_back({0, 1 + 2 * i});
    expected.push_back({1 + 2 * i, 2 + 2 * i});
  }
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(findCrossingTriangles(mesh, 2 * kPairs).pairs, expected);
  const CrossingTriangles few = findCrossingTriangles(mesh, kPairs);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(few.pairs.size(), kPairs);
  EXPECT_EQ(findCrossingTriangles(mesh, kPairs).pairs, few.pairs) << "the same for any number of threads";
}

TEST(CrossingTriangles, OfFansAndThinFoldsAreExact) {
  // Around a fan of slivers no triangles cross; a triangle that touches only the far end of one sliver does.
  constexpr std::uint32_t kSlivers = 2000;
  TriangleMesh fan = test::fanOfSlivers(kSlivers);
  EXPECT_TRUE(findCrossingTriangles(fan, 100).pairs.empty());
  fan.positions.insert(fan.positions.end(), {{1, 0, 0}, {2, 0, 1}, {2, 0, -1}});  // its corner is that of the slivers 0 and 1999
  fan.triangles.push_back({kSlivers + 1, kSlivers + 2, kSlivers + 3});
  const std::vector<std::pair<std::uint32_t, std::uint32_t>> expected{{0, kSlivers}, {kSlivers - 1, kSlivers}};
  EXPECT_EQ(findCrossingTriangles(fan, 100).pairs, expected);
}

TEST(CrossingTriangles, OfFansAndSliversAreThoseOfAllPairs) {
  // Fans of 100 triangles in space and in a plane, a ring of slivers that lie askew, and triangles anywhere.
  test::Random random(11);
  std::size_t total = 0;
  for (int round = 0; round < 6; ++round) {
    TriangleMesh mesh;
    const auto add = [&](const Eigen::Vector3d& p) {
      mesh.positions.push_back(p);
      return static_cast<std::uint32_t>(mesh.positions.size() - 1);
    };
    const Eigen::Vector3d offset = round % 2 ? Eigen::Vector3d(1000, -2000, 500) : Eigen::Vector3d::Zero();
    const std::uint32_t hub = add(offset + random.inCube(1));
    for (int i = 0; i < 100; ++i) {
      const Eigen::Vector3d along = random.inCube(2);
      mesh.triangles.push_back({add(mesh.positions[hub] + along), hub, add(mesh.positions[hub] + along + random.inCube(0.4))});
    }
    const std::uint32_t middle = add(offset), first = static_cast<std::uint32_t>(mesh.positions.size());
    for (std::uint32_t i = 0; i < 400; ++i) {
      const double angle = 2 * std::numbers::pi * i / 400;
      add(offset + Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.1));
      add(offset + Eigen::Vector3d(2 * std::cos(angle), 2 * std::sin(angle), 0.1 * (round % 3)));
    }
    for (std::uint32_t i = 0; i < 400; ++i) {
      const std::uint32_t a = first + 2 * i, b = first + 2 * ((i + 1) % 400);
      mesh.triangles.insert(mesh.triangles.end(), {{middle, a, b}, {a, a + 1, b + 1}, {a, b + 1, b}});
    }
    for (int i = 0; i < 60; ++i) {
      const Eigen::Vector3d at = offset + random.inCube(2);
      mesh.triangles.push_back({add(at), add(at + random.inCube(0.5)), add(at + random.inCube(0.5))});
    }
    std::vector<std::pair<std::uint32_t, std::uint32_t>> expected;
    for (std::uint32_t a = 0; a < mesh.triangles.size(); ++a)
      for (std::uint32_t b = a + 1; b < mesh.triangles.size(); ++b)
        if (doCross(mesh.positions, mesh.triangles[a], mesh.triangles[b])) expected.emplace_back(a, b);
    EXPECT_EQ(findCrossingTriangles(mesh, 1000000).pairs, expected) << round;
    total += expected.size();
  }
  EXPECT_GT(total, 1000u);
}

TEST(CrossingTriangles, StopAtTheLimit) {
  const TriangleMesh mesh = joined(boxMesh({0, 0, 0}, {2, 2, 2}), boxMesh({1, 1, 1}, {3, 3, 3}));
  const CrossingTriangles all = findCrossingTriangles(mesh, 1000);
  ASSERT_GT(all.pairs.size(), 5u);
  EXPECT_FALSE(all.is_stopped);
  EXPECT_FALSE(findCrossingTriangles(mesh, all.pairs.size()).is_stopped);
  const CrossingTriangles few = findCrossingTriangles(mesh, 5);
  EXPECT_TRUE(few.is_stopped);
  EXPECT_EQ(few.pairs.size(), 5u);
}

}  // namespace
}  // namespace spheretree::builder
