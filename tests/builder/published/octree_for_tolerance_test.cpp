// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/octree_for_tolerance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "certify/certify_cover.h"
#include "measure/coverage.h"
#include "medial/refit_ball.h"
#include "spheretree/core/mesh_edit.h"
#include "spheretree/core/smallest_enclosing_ball.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

double worstOverhang(const DistanceField& field, const std::vector<Ball>& balls) {
  double worst = 0;
  for (const Ball& b : balls) worst = std::max(worst, b.radius + field.signedDistance(b.centre));
  return worst;
}

LevelBalls buildFor(const TriangleMesh& mesh, double tolerance, int levels = 4) {
  const DistanceField field(mesh);
  Progress progress;
  PublishedSettings settings;
  settings.tolerance_mm = tolerance;
  settings.levels = levels;
  return buildOctreeForTolerance(mesh, field, settings, progress);
}

// Overhang of a ball around a unit cube.
const double kOfCube = std::sqrt(0.75) - 0.5;

TEST(OctreeForTolerance, DividesAsFarAsItNeeds) {
  struct Case {
    const char* what;
    TriangleMesh mesh;
    double tolerance;
    std::vector<std::size_t> counts;
  };
  const std::vector<Case> cases{
      {"one ball is enough", test::boxMesh({0, 0, 0}, {1, 1, 1}), kOfCube + 1e-6, {1}},
      {"octants of a cube", test::boxMesh({0, 0, 0}, {1, 1, 1}), kOfCube / 2 + 1e-6, {1, 8}},
      {"cubes along a beam: not one is halved across", test::boxMesh({0, 0, 0}, {8, 1, 1}), kOfCube + 1e-6, {1, 8}},
      {"cubes of a plate", test::boxMesh({0, 0, 0}, {8, 8, 1}), kOfCube + 1e-6, {1, 8, 64}},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.what);
    const LevelBalls tree = buildFor(c.mesh, c.tolerance);
    ASSERT_EQ(tree.balls.size(), c.counts.size());
    EXPECT_EQ(tree.balls.back().size(), c.counts.back());
    for (std::size_t level = 0; level < c.counts.size(); ++level) EXPECT_LE(tree.balls[level].size(), c.counts[level]);
    EXPECT_LE(worstOverhang(DistanceField(c.mesh), tree.balls.back()), c.tolerance);
  }
}

TEST(OctreeForTolerance, CellsThatOneBallCanHoldAreJoined) {
  // The first plane cuts the second of three cubes: four cells contain surface.
  const TriangleMesh cubes =
      joined(joined(test::boxMesh({0, 0, 0}, {1, 1, 1}), test::boxMesh({1.7, 0, 0}, {2.7, 1, 1})), test::boxMesh({4, 0, 0}, {5, 1, 1}));
  const LevelBalls tree = buildFor(cubes, kOfCube + 1e-6);
  ASSERT_EQ(tree.balls.back().size(), 3u);
  EXPECT_LE(worstOverhang(DistanceField(cubes), tree.balls.back()), kOfCube + 1e-6);
}

// The smallest number of boxes by a full search: each box either has a surface that one ball covers within the
// tolerance, or is divided into two halves across any side. The surface is a dense sample.
class FullSearch {
 public:
  FullSearch(const TriangleMesh& mesh, double tolerance) : field_(mesh), tolerance_(tolerance) {
    for (const SurfacePoint& s : spreadOverSurface(mesh, 20'000, 1)) surface_.push_back(s.point);
  }
  static constexpr int kOutOfReach = 1 << 20;
  int smallestCount() { return smallestCountOf(field_.box(), surface_, {}); }

 private:
  static constexpr int kHalvings = 3;
  using Key = std::array<int, 6>;  // number of halvings along each axis, and the index of the part

  int smallestCountOf(const Eigen::AlignedBox3d& box, const std::vector<Eigen::Vector3d>& points, const Key& key) {
    if (points.empty()) return 0;
    const auto [at, is_new] = known_.try_emplace(key, 1);
    if (!is_new || keeps(box, points)) return at->second;
    int smallest = kOutOfReach;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (key[axis] == kHalvings) continue;
      const double middle = box.center()[static_cast<int>(axis)];
      int sum = 0;
      for (int side = 0; side < 2; ++side) {
        Eigen::AlignedBox3d half = box;
        (side ? half.min() : half.max())[static_cast<int>(axis)] = middle;
        std::vector<Eigen::Vector3d> inside;
        for (const Eigen::Vector3d& p : points)
          if ((p[static_cast<int>(axis)] > middle) == (side == 1)) inside.push_back(p);
        Key next = key;
        ++next[axis];
        next[axis + 3] = 2 * next[axis + 3] + side;
        sum += smallestCountOf(half, inside, next);
      }
      smallest = std::min(smallest, sum);
    }
    return known_[key] = smallest;
  }

  bool keeps(const Eigen::AlignedBox3d& box, const std::vector<Eigen::Vector3d>& points) const {
    const Ball smallest = smallestEnclosing(points);
    if (smallest.radius + field_.signedDistance(smallest.centre) <= tolerance_) return true;
    const double clearance = -field_.signedDistance(box.center());
    return clearance > 0 && refitBall(field_, points, box.center(), clearance, 0.1 * box.diagonal().norm(), 24).stand_off <= tolerance_;
  }

  DistanceField field_;
  double tolerance_;
  std::vector<Eigen::Vector3d> surface_;
  std::map<Key, int> known_;
};

TEST(OctreeForTolerance, NeedsHardlyMoreThanAFullSearch) {
  struct Case {
    const char* what;
    TriangleMesh mesh;
    std::vector<double> tolerances;
  };
  const std::vector<Case> cases{{"box", test::boxMesh({0, 0, 0}, {3, 2, 1}), {0.2, 0.3, 0.5}},
                                {"plate", test::boxMesh({0, 0, 0}, {8, 6, 0.5}), {0.5, 0.8, 1.2}},
                                {"thin ring", test::torusMesh(5, 1, 30, 12), {0.6, 1, 1.6}},
                                {"thick ring", test::torusMesh(5, 3, 30, 16), {1, 1.6}}};
  for (const Case& c : cases)
    for (const double tolerance : c.tolerances) {
      SCOPED_TRACE(std::string(c.what) + ", tolerance " + std::to_string(tolerance));
      const int smallest = FullSearch(c.mesh, tolerance).smallestCount();
      ASSERT_LT(smallest, FullSearch::kOutOfReach);
      // More than 1.2 times as many where the longest side is not the best one to halve: the faces of a box.
      EXPECT_LE(static_cast<double>(buildFor(c.mesh, tolerance).balls.back().size()), 1.5 * smallest);
    }
}

TEST(OctreeForTolerance, EveryLevelCovers) {
  Progress progress;
  for (const double tolerance : {0.1, 0.2, 0.8}) {
    const TriangleMesh mesh = test::torusMesh(5, 1, 30, 12);
    const LevelBalls tree = buildFor(mesh, tolerance);
    for (const std::vector<Ball>& balls : tree.balls)
      EXPECT_LT(certifyCover(mesh, balls, Eigen::Vector3d::Zero(), 1e-3, progress).largest_growth, 1e-2);
    EXPECT_LE(worstOverhang(DistanceField(mesh), tree.balls.back()), tolerance);
  }
}

TEST(OctreeForTolerance, OutOfReachGivesWhatTheBudgetCan) {
  const TriangleMesh mesh = test::torusMesh(5, 1, 30, 12);
  const DistanceField field(mesh);
  double smallest = 8;  // tolerance that the budget allows
  for (double tolerance = smallest; worstOverhang(field, buildFor(mesh, tolerance, 3).balls.back()) <= tolerance; tolerance /= 1.1)
    smallest = tolerance;
  EXPECT_LT(smallest, 1);
  const LevelBalls tree = buildFor(mesh, 1e-3, 3);
  ASSERT_EQ(tree.balls.size(), 3u);
  EXPECT_LE(tree.balls.back().size(), 64u);
  EXPECT_LE(worstOverhang(field, tree.balls.back()), 1.1 * smallest);
}

}  // namespace
}  // namespace spheretree::builder
