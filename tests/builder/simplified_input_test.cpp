// SPDX-License-Identifier: GPL-3.0-or-later
#include "simplified_input.h"

#include <gtest/gtest.h>

#include <random>

#include "base/random.h"
#include "mesh/canonical_order.h"
#include "mesh/simplify_mesh.h"
#include "spheretree/builder/mesh_checks.h"
#include "spheretree/core/mesh_edit.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

TEST(SimplifiedInput, ResultsAreMappedBackToTheMesh) {
  const TriangleMesh mesh = test::boxMesh({10, 20, 30}, {11, 24, 32});
  Progress progress;
  const SimplifiedInput search = simplifyInput(mesh, {}, {}, {}, progress);
  EXPECT_EQ(search.simplified_triangles, 0u);
  EXPECT_EQ(search.mesh.triangles.size(), mesh.triangles.size());
  LevelBalls found;
  found.balls = {{{Vector3d::Zero(), 1}}, {{search.mesh.positions[0], 0.5}, {search.mesh.positions[7], 0.25}}};
  found.parents = {{kNone}, {0, 0}};
  const LevelBalls there = inFrameOfMesh(found, search.pose);
  EXPECT_EQ(there.parents, found.parents);
  EXPECT_TRUE(there.balls[0][0].centre.isApprox(Vector3d(10.5, 22, 31), 1e-9));
  const DistanceField field(mesh);
  EXPECT_NEAR(field.signedDistance(there.balls[0][0].centre), search.pose.scale * search.field.signedDistance(Vector3d::Zero()), 1e-6);
  for (const Ball& b : there.balls[1]) EXPECT_LE(field.distance(b.centre), kPoseRounding * search.pose.scale) << "a corner stays one";
  EXPECT_DOUBLE_EQ(there.balls[1][0].radius, 0.5 * search.pose.scale);
}

// The additional overhang that a graded tree may have at a triangle stays with the triangle.
TEST(SimplifiedInput, SlackFollowsItsTriangle) {
  const TriangleMesh mesh = test::boxMesh({0, 0, 0}, {1, 4, 2});
  BuildSettings settings;
  settings.tolerance_mm = 0.1;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) settings.tolerance_of_triangle_mm.push_back(0.1 + 0.01 * static_cast<double>(t));
  const std::vector<double> slack = [&] {
    std::vector<double> out = settings.tolerance_of_triangle_mm;
    for (double& s : out) s -= settings.tolerance_mm;
    return out;
  }();
  const DistanceField graded(mesh, slack);
  Progress progress;
  const SimplifiedInput search = simplifyInput(mesh, {}, {}, settings, progress);
  for (const Vector3d& p : {Vector3d(0, 0, 0), Vector3d(0.4, -0.3, 0.1), Vector3d(-0.9, 0.2, 0.3)})
    EXPECT_NEAR(search.pose.scale * search.field.signedDistance(p), graded.signedDistance(search.pose.toMesh(p)), 1e-6);
}

// Rounding to the grid of the pose would invert a plate whose thickness is a billionth of its width: the outside must
// stay outside.
TEST(SimplifiedInput, AMeshThatThePoseWouldFoldIsNotSimplified) {
  const auto searched = [](double thickness) {
    Progress progress;
    return simplifyInput(test::boxMesh({0, 0, 0}, {1, 2, thickness}), {}, {}, {}, progress);
  };
  EXPECT_NE(searched(1e-3).pose.scale, 1);
  const SimplifiedInput thin = searched(1e-9);
  EXPECT_EQ(thin.pose.scale, 1);
  EXPECT_EQ(thin.pose.turn, Eigen::Matrix3d::Identity());
  EXPECT_EQ(thin.pose.toMesh({1, 2, 3}), Vector3d(1, 2, 3));
  for (const Vector3d& p : {Vector3d(0.5, 0.5, 2e-9), Vector3d(0.5, 0.5, -1e-9), Vector3d(-0.1, 1, 1e-9), Vector3d(2, 3, -1)})
    EXPECT_GT(thin.field.signedDistance(p), 0);
  EXPECT_NEAR(thin.field.signedDistance({0.5, 0.5, 0.5e-9}), -0.5e-9, 1e-15);
}

TEST(SimplifiedInput, AMeshFinerThanItsLeavesIsSimplified) {
  const TriangleMesh mesh = test::sphereMesh(3, 7);  // 131,072 triangles
  BuildSettings settings;
  settings.levels = 2;
  Progress progress;
  const SimplifiedInput search = simplifyInput(mesh, {}, {}, settings, progress);
  EXPECT_EQ(search.simplified_triangles, search.mesh.triangles.size());
  EXPECT_LT(search.mesh.triangles.size(), 21'000u);
  for (const Vector3d& p : mesh.positions)
    ASSERT_LE(search.pose.scale * search.field.distance(search.pose.turn.transpose() * (p - search.pose.centre) / search.pose.scale),
              search.distance_bound_mm);
}

// Noise as large as a triangle makes it fold over itself in some places once it is simplified.
TEST(SimplifiedInput, FoldsOfANoisyMeshAreRemoved) {
  TriangleMesh mesh = test::sphereMesh(3, 7);
  std::mt19937_64 random(1);
  for (Vector3d& p : mesh.positions) p += 0.02 * (2 * randomUnit(random) - 1) * p.normalized();
  ASSERT_TRUE(checkMesh(mesh).clean());
  BuildSettings settings;
  settings.levels = 2;
  Progress progress;
  const TriangleMesh ordered = inCanonicalOrder(inPose(mesh, canonicalPose(mesh))).mesh;
  EXPECT_FALSE(checkMesh(simplifyMesh(ordered, 20'000, progress)).clean()) << "the case is no case";
  const SimplifiedInput search = simplifyInput(mesh, {}, {}, settings, progress);
  EXPECT_GT(search.simplified_triangles, 19'000u);
  EXPECT_LE(search.simplified_triangles, 20'000u);
  EXPECT_TRUE(checkMesh(search.mesh).clean());
}

// The search covers all of it, but distances are to the solid and to the sheets outside.
TEST(SimplifiedInput, HoldsWhatIsToBeCoveredToo) {
  const TriangleMesh mesh = test::boxMesh({0, 0, 0}, {1, 2, 3});
  TriangleMesh within, beside;
  within.positions = {{0.4, 0.4, 0.4}, {0.6, 0.4, 0.4}, {0.4, 0.6, 0.4}};
  within.triangles = {{0, 1, 2}};
  beside.positions = {{2, 0, 0}, {2, 1, 0}, {2, 0, 1}};
  beside.triangles = {{0, 1, 2}};
  Progress progress;
  const SimplifiedInput search = simplifyInput(mesh, beside, joined(within, beside), {}, progress);
  EXPECT_EQ(search.mesh.triangles.size(), mesh.triangles.size() + 2);
  EXPECT_EQ(search.field.triangleCount(), mesh.triangles.size() + 1);
  for (std::size_t t = mesh.triangles.size(); t < search.mesh.triangles.size(); ++t) {
    const Eigen::Vector3d corner = search.pose.toMesh(search.mesh.corner(t, 0));
    EXPECT_NEAR(search.pose.scale * search.field.signedDistance(search.mesh.corner(t, 0)), corner.x() < 1 ? -0.4 : 0.0, 1e-8);
  }
}

}  // namespace
}  // namespace spheretree::builder
