// SPDX-License-Identifier: GPL-3.0-or-later
#include "certify/prove_tree.h"

#include <gtest/gtest.h>

#include <cmath>

#include "certify/certify_cover.h"
#include "spheretree/builder/build_sphere_tree.h"
#include "support/dense_points.h"
#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

TriangleMesh cube() { return test::boxMesh(Vector3d::Constant(-1), Vector3d::Constant(1)); }

bool isCovered(const TriangleMesh& mesh, std::span<const Sphere> spheres, const Vector3d& origin = Vector3d::Zero()) {
  Progress progress;
  return provenCovered(mesh, spheres, origin, progress);
}

BuildResult builtTree(const TriangleMesh& mesh) {
  BuildSettings settings;
  settings.levels = 3;
  settings.quality = Quality::Quick;
  Progress progress;
  return buildSphereTree(mesh, settings, progress);
}

TEST(ProveTree, DoesNotDoubtWhatCertificationHasProven) {
  test::Random random(3);
  for (const TriangleMesh& mesh : {cube(), test::sphereMesh(2, 3)}) {
    for (int n = 0; n < 6; ++n) {
      const Vector3d origin = n % 2 ? Vector3d(random.inCube(50)) : Vector3d::Zero();
      std::vector<Ball> balls;
      for (int k = 0; k < 60; ++k) balls.push_back({random.inCube(2), random.between(0.1, 1)});
      Progress progress;
      EXPECT_TRUE(isCovered(mesh, certifyCover(mesh, balls, origin, 1e-2, progress).spheres, origin)) << n;
    }
  }
}

TEST(ProveTree, SeesEveryGapThatAPointLiesIn) {
  test::Random random(5);
  const TriangleMesh mesh = cube();
  const std::vector<Vector3d> points = test::densePoints(mesh, 40, 1);
  int open = 0;
  for (int n = 0; n < 200; ++n) {
    std::vector<Sphere> spheres;
    for (int k = 0; k < 60; ++k) {
      const Vector3d c = random.inCube(1.2);
      spheres.push_back({float(c.x()), float(c.y()), float(c.z()), float(random.between(0.3, 1.1))});
    }
    const bool has_gap = std::ranges::any_of(points, [&](const Vector3d& p) {
      return std::ranges::none_of(spheres, [&](const Sphere& s) { return (p - Vector3d(s.x, s.y, s.z)).norm() <= double{s.radius}; });
    });
    open += has_gap;
    EXPECT_FALSE(has_gap && isCovered(mesh, spheres)) << n;
  }
  EXPECT_GT(open, 20);
  EXPECT_LT(open, 200);
}

TEST(ProveTree, NamesTheLevelThatNoLongerCovers) {
  const TriangleMesh mesh = test::sphereMesh(2, 3);
  const SphereTree tree = builtTree(mesh).tree;
  const DistanceField field(mesh);
  Progress progress;
  ASSERT_EQ(findUnproven(mesh, field, tree, progress), "");
  for (const std::uint32_t node : levelSet(tree, 2)) {
    SphereTree smaller = tree;
    smaller.cover[node].radius *= 0.6f;
    EXPECT_NE(findUnproven(mesh, field, smaller, progress).find("level 2"), std::string::npos) << node;
  }
}

TEST(ProveTree, NamesTheSphereThatReachesOutTooFar) {
  const TriangleMesh mesh = test::sphereMesh(2, 3);
  SphereTree tree = builtTree(mesh).tree;
  const DistanceField field(mesh);
  Progress progress;
  tree.statistics[1].overhang_bound *= 0.9f;
  EXPECT_NE(findUnproven(mesh, field, tree, progress).find("level 1: node"), std::string::npos);
}

}  // namespace
}  // namespace spheretree::builder
