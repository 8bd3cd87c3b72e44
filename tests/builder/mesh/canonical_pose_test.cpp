// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/canonical_pose.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mesh/canonical_order.h"
#include "spheretree/builder/build_sphere_tree.h"
#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

TriangleMesh inOtherPose(TriangleMesh mesh, std::uint64_t seed, double scale = 1) {
  test::Random random(seed);
  const Vector3d axis = random.direction(), shift = random.inCube(10);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(random.between(0.3, 3), axis).toRotationMatrix();
  for (Vector3d& p : mesh.positions) p = scale * (turn * p) + shift;
  return mesh;
}

// An object without symmetry: no two axes and no two ends are alike.
TriangleMesh lopsided() {
  TriangleMesh mesh = test::sphereMesh(2, 3);
  for (Vector3d& p : mesh.positions) {
    p = Vector3d(2 * p.x() + 0.2 * p.x() * p.x(), 1.3 * p.y(), p.z());
    p.y() += 0.1 * p.y() * p.y() + 0.1 * p.x() * p.z();
  }
  return mesh;
}

TEST(CanonicalPose, IsTheSameForEveryTurnPlaceAndSize) {
  const TriangleMesh mesh = lopsided(), posed = inCanonicalOrder(inPose(mesh, canonicalPose(mesh))).mesh;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const TriangleMesh other = inOtherPose(mesh, seed, 1 + 0.17 * static_cast<double>(seed));
    const TriangleMesh other_posed = inCanonicalOrder(inPose(other, canonicalPose(other))).mesh;
    EXPECT_EQ(other_posed.positions, posed.positions) << seed;
    EXPECT_EQ(other_posed.triangles, posed.triangles) << seed;
  }
}

TEST(CanonicalPose, AMeshCutFinerKeepsItsPose) {
  const TriangleMesh mesh = lopsided();
  const Pose pose = canonicalPose(mesh), finer = canonicalPose(test::quartered(mesh));
  EXPECT_TRUE(finer.turn.isApprox(pose.turn, 1e-9));
  EXPECT_TRUE(finer.centre.isApprox(pose.centre, 1e-9));
  EXPECT_NEAR(finer.scale, pose.scale, 1e-9 * pose.scale);
}

TEST(CanonicalPose, TurnsBackToWhereItWas) {
  for (const TriangleMesh& mesh : {lopsided(), test::boxMesh({0, 0, 0}, {1, 1, 1}), test::sphereMesh(3, 3), test::torusMesh(5, 1, 24, 10),
                                   test::boxMesh({0, 0, 0}, {100, 0.1, 0.1})}) {
    const Pose pose = canonicalPose(mesh);
    EXPECT_TRUE((pose.turn.transpose() * pose.turn).isIdentity(1e-12));
    EXPECT_NEAR(pose.turn.determinant(), 1, 1e-12);
    const TriangleMesh posed = inPose(mesh, pose);
    EXPECT_EQ(posed.triangles, mesh.triangles);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
      EXPECT_LE((pose.toMesh(posed.positions[v]) - mesh.positions[v]).norm(), kPoseRounding * pose.scale);
  }
}

TEST(CanonicalPose, TheLongestAxisComesFirstWithItsHeavierTailOnThePositiveSide) {
  TriangleMesh mesh = test::boxMesh({-1, -2, -5}, {1, 2, 5});
  for (Vector3d& p : mesh.positions)
    if (p.z() < 0) p.head<2>() *= 2;  // so that the surface reaches farther from its centroid at the thin end: z > 0
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const TriangleMesh other = inOtherPose(mesh, seed);
    const Pose pose = canonicalPose(other);
    const Vector3d thin = (other.positions[4] + other.positions[7]) / 2, thick = (other.positions[0] + other.positions[3]) / 2;
    EXPECT_NEAR(pose.turn.col(0).dot((thin - thick).normalized()), 1, 1e-9);
  }
}

// Moments cannot distinguish the axes of these objects; their faces can.
TEST(CanonicalPose, FacesOfCubesAndSquarePlatesLieOnTheAxes) {
  for (const Vector3d& size : {Vector3d(1, 1, 1), Vector3d(1, 1, 0.01), Vector3d(1, 1, 3), Vector3d(3, 2, 1)})
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const TriangleMesh mesh = inOtherPose(test::boxMesh(-size, size), seed);
      Vector3d sorted = size;
      std::sort(sorted.data(), sorted.data() + 3, std::greater<>());
      const Pose pose = canonicalPose(mesh);
      for (const Vector3d& p : inPose(mesh, pose).positions)
        EXPECT_TRUE((pose.scale * p.cwiseAbs()).isApprox(sorted, 1e-6)) << (pose.scale * p).transpose();
    }
}

// A box can be turned onto itself, but its diagonals cannot.
TEST(CanonicalPose, SymmetricObjectsComeOutTheSameToo) {
  for (const Vector3d& size : {Vector3d(1, 1, 1), Vector3d(1, 1, 0.01), Vector3d(3, 2, 1)}) {
    const TriangleMesh mesh = test::boxMesh(-size, size), posed = inCanonicalOrder(inPose(mesh, canonicalPose(mesh))).mesh;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const TriangleMesh other = inOtherPose(mesh, seed);
      const TriangleMesh other_posed = inCanonicalOrder(inPose(other, canonicalPose(other))).mesh;
      EXPECT_EQ(other_posed.positions, posed.positions) << size.transpose() << ", " << seed;
      EXPECT_EQ(other_posed.triangles, posed.triangles) << size.transpose() << ", " << seed;
    }
  }
}

TEST(CanonicalPose, TreesDoNotDependOnThePose) {
  const TriangleMesh mesh = lopsided();
  Progress progress;
  for (const BuilderKind kind : {BuilderKind::Cover, BuilderKind::Merge, BuilderKind::Grid, BuilderKind::Octree}) {
    BuildSettings settings;
    settings.builder = kind;
    settings.quality = Quality::Quick;
    settings.levels = 3;
    const auto boundOf = [&](const TriangleMesh& m) {
      return buildSphereTree(m, settings, progress).statistics.levels.back().overhang_bound_mm;
    };
    const double bound = boundOf(mesh);
    for (std::uint64_t seed = 1; seed <= 4; ++seed) EXPECT_NEAR(boundOf(inOtherPose(mesh, seed)), bound, 5e-3 * bound) << name(kind);
  }
}

}  // namespace
}  // namespace spheretree::builder
