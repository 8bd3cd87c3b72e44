// SPDX-License-Identifier: GPL-3.0-or-later
// The single steps of a repair, each against a closed form or a planted fault.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "spheretree/builder/farthest_point.h"
#include "spheretree/builder/fill_holes.h"
#include "spheretree/builder/mesh_checks.h"
#include "spheretree/builder/repair_soup.h"
#include "spheretree/builder/resolve_overlaps.h"
#include "spheretree/builder/separate_fans.h"
#include "spheretree/builder/winding_number.h"
#include "spheretree/builder/wrap_surface.h"
#include "support/mesh_measures.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
using test::boxMesh;

RepairSoup soupOf(const TriangleMesh& mesh) {
  RepairSoup soup{mesh, std::vector<std::uint32_t>(mesh.triangles.size())};
  std::iota(soup.source.begin(), soup.source.end(), 0u);
  return soup;
}

TEST(WindingNumber, IsOneInsideAndNoneOutside) {
  const TriangleMesh torus = test::torusMesh(5, 2, 48, 24);
  const WindingNumber winding(torus);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> across(-8, 8);
  int inside = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vector3d p(across(random), across(random), 0.5 * across(random));
    const double off = std::hypot(std::hypot(p.x(), p.y()) - 5, p.z()) - 2;
    if (std::abs(off) < 0.1) continue;  // the mesh is not quite round
    inside += off < 0;
    EXPECT_NEAR(winding.at(p), off < 0 ? 1 : 0, 0.03) << p.transpose();
  }
  EXPECT_GT(inside, 500);
}

TEST(WindingNumber, OnAFaceLeftOutIsTheMeanOfBothSides) {
  const TriangleMesh box = boxMesh({0, 0, 0}, {1, 1, 1});
  for (std::uint32_t t = 0; t < 12; ++t) {
    const Vector3d middle = (box.corner(t, 0) + box.corner(t, 1) + box.corner(t, 2)) / 3;
    EXPECT_NEAR(WindingNumber(box).at(middle, std::vector{t}), 0.5, 1e-9);
  }
}

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

TEST(FillHoles, LeavesNoEdgeOpen) {
  std::mt19937_64 random(4);
  for (int round = 0; round < 20; ++round) {
    RepairSoup soup = soupOf(test::sphereMesh(1, 3));
    const std::size_t share = 2 + random() % 20;  // of half the triangles to one in 21: loops that meet in vertices
    std::erase_if(soup.mesh.triangles, [&](const Triangle&) { return random() % share == 0; });
    soup.source.resize(soup.mesh.triangles.size());
    const std::size_t open = findOpenEdges(soup.mesh).size();
    std::size_t filled = 0;
    for (const FilledHole& hole : fillHoles(soup)) filled += hole.edges;
    EXPECT_EQ(filled, open);
    EXPECT_TRUE(findOpenEdges(soup.mesh).empty());
    EXPECT_EQ(soup.source.size(), soup.mesh.triangles.size());
  }
}

TEST(FillHoles, FromTheMiddleWhereThereAreTooManyEdges) {
  RepairSoup soup = soupOf(boxMesh({0, 0, 0}, {1, 1, 1}));
  soup.mesh.triangles.erase(soup.mesh.triangles.begin(), soup.mesh.triangles.begin() + 2);  // the bottom
  soup.source.resize(10);
  const auto holes = fillHoles(soup, 3);
  ASSERT_EQ(holes.size(), 1u);
  EXPECT_EQ(holes[0].triangles.size(), 4u);
  EXPECT_NEAR(holes[0].length, 4, 1e-12);
  EXPECT_NEAR(test::volumeOf(soup.mesh), 1, 1e-12);
}

TEST(WrapSurface, StopsWhenAsked) {
  Progress progress;
  progress.cancel();
  EXPECT_THROW(wrapSurface(boxMesh({0, 0, 0}, {1, 1, 1}), 0.05, 0.01, progress), Cancelled);
}

// A row of boxes, each turned a little and pushed into the one before: the union by a grid of points is the oracle.
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
  const Resolved resolved = resolveOverlaps(soup, 100000, progress);
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

// Rectangles in one plane, cut alike from both sides whatever the ties of Delaunay: a wall of bricks of two sizes.
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
  resolveOverlaps(soup, 100000, progress);
  EXPECT_TRUE(findOpenEdges(soup.mesh).empty());
  EXPECT_NEAR(test::volumeOf(soup.mesh), 4, 1e-12);
  EXPECT_NEAR(test::areaOf(soup.mesh), 2 * (2 * 2 + 2 * 1 + 2 * 1), 1e-12);
}

TEST(SeparateFans, DrawsApartByTheDistanceAsked) {
  TriangleMesh both = boxMesh({0, 0, 0}, {1, 1, 1});
  const TriangleMesh other = boxMesh({1, 1, 0}, {2, 2, 1});  // one edge in common: vertices 3 and 7 there are 0 and 4 here
  both.positions.insert(both.positions.end(), other.positions.begin(), other.positions.end());
  for (const Triangle& t : other.triangles) {
    Triangle moved;
    for (std::size_t k = 0; k < 3; ++k) moved[k] = t[k] == 0 ? 3 : t[k] == 4 ? 7 : t[k] + 8;
    both.triangles.push_back(moved);
  }
  EXPECT_TRUE(checkMesh(both).has(DefectKind::NonManifoldEdge));
  RepairSoup soup = soupOf(both);
  const SeparatedFans fans = separateFans(soup, 1e-4);
  both = soup.mesh;
  dropUnusedVertices(both);
  EXPECT_EQ(fans.copies, 4u);  // both ends once more, and two vertices in the middle
  EXPECT_EQ(soup.source.size(), both.triangles.size());
  EXPECT_NEAR(fans.moved, 1e-4, 1e-12);
  EXPECT_TRUE(checkMesh(both).clean()) << checkMesh(both).summary();
  EXPECT_EQ(checkMesh(both).components.size(), 2u);
}

TEST(FarthestFrom, BoundsTheDistanceClosely) {
  const TriangleMesh sphere = test::sphereMesh(1, 4), box = boxMesh({-2, -2, -2}, {2, 2, 2});
  std::vector<std::uint32_t> all(box.triangles.size());
  std::iota(all.begin(), all.end(), 0u);
  Progress progress;
  const double bound = farthestFrom(DistanceField(sphere), box, all, 1e-3, progress), exact = std::sqrt(12) - 1;
  EXPECT_GE(bound, exact - 5e-3);  // the sphere is of facets
  EXPECT_LE(bound, exact * 1.05 + 5e-3);
  EXPECT_LE(farthestFrom(DistanceField(box), box, all, 1e-9, progress), 1e-9);  // at once, though nothing is smaller than its bound
}

TEST(NotDeepWithin, LeavesOutOnlyWhatIsDeep) {
  const TriangleMesh box = boxMesh({0, 0, 0}, {10, 10, 10});
  TriangleMesh plane;  // through the middle, and out on all sides
  plane.positions = {{-5, -5, 5}, {25, -5, 5}, {-5, 25, 5}};
  plane.triangles = {{0, 1, 2}};
  const DistanceField field(box);
  Progress progress;
  const TriangleMesh kept = notDeepWithin(field, plane, std::vector<std::uint32_t>{0}, 1, progress);
  const double cut = test::areaOf(plane) - test::areaOf(kept);
  EXPECT_LE(cut, 64);  // the square of 8 mm that is deep
  EXPECT_GE(cut, 49);
  for (std::size_t t = 0; t < kept.triangles.size(); ++t)
    EXPECT_GE(field.signedDistance((kept.corner(t, 0) + kept.corner(t, 1) + kept.corner(t, 2)) / 3), -1.3);
}

}  // namespace
}  // namespace spheretree::builder
