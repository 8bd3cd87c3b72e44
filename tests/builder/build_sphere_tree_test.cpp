// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/build_sphere_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "spheretree/builder/provenance.h"
#include "spheretree/core/sphere_tree_codec.h"
#include "support/dense_points.h"
#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

BuildSettings quick(int levels = 3, int branching = 4) {
  BuildSettings settings;
  settings.quality = Quality::Quick;
  settings.levels = levels;
  settings.branching = branching;
  return settings;
}

BuildResult build(const TriangleMesh& mesh, const BuildSettings& settings) {
  Progress progress;
  return buildSphereTree(mesh, settings, progress);
}

std::vector<Ball> levelBalls(const SphereTree& tree, int level) {
  std::vector<Sphere> spheres;
  for (const std::uint32_t node : levelSet(tree, level)) spheres.push_back(tree.cover[node]);
  return test::toBalls(spheres, {tree.origin_mm[0], tree.origin_mm[1], tree.origin_mm[2]});
}

TriangleMesh tetrahedron() {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {3, 0, 0}, {0, 2, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

// The tree is sound, every level covers every dense point, and no point of a sphere is farther out than the level's
// bound.
void expectCertified(const TriangleMesh& mesh, const BuildResult& result, const BuildSettings& settings) {
  const SphereTree& tree = result.tree;
  EXPECT_EQ(findFault(tree), "");
  if (tree.levelCount() != settings.levels) {
    EXPECT_LT(tree.levelCount(), settings.levels);
    EXPECT_LT(result.statistics.levels.back().overhang_bound_mm, 0.01 * DistanceField(mesh).diagonal())
        << "only a round object needs fewer";
  }
  EXPECT_EQ(tree.branching, settings.branching);
  const DistanceField field(mesh);
  const double rounding = 4e-16 * std::max(field.box().min().cwiseAbs().maxCoeff(), field.box().max().cwiseAbs().maxCoeff());
  const int inner = static_cast<int>(std::clamp<std::size_t>(20000 / mesh.triangles.size(), 10, 2000));
  const std::vector<Vector3d> points = test::densePoints(mesh, inner, 7);
  test::Random random(3);
  for (int level = 0; level < tree.levelCount(); ++level) {
    const std::vector<Ball> balls = levelBalls(tree, level);
    EXPECT_LE(test::largestGap(points, balls), rounding) << "level " << level;
    const LevelStatistics& stored = tree.statistics[static_cast<std::size_t>(level)];
    EXPECT_EQ(stored.sphere_count, balls.size());
    double overhang = 0;
    for (const Ball& b : balls)
      for (int i = 0; i < 60; ++i) overhang = std::max(overhang, field.signedDistance(b.centre + b.radius * random.direction()));
    EXPECT_LE(overhang, static_cast<double>(stored.overhang_bound)) << "level " << level;
    const LevelBuildStatistics& told = result.statistics.levels[static_cast<std::size_t>(level)];
    EXPECT_EQ(told.spheres, balls.size());
    EXPECT_LE(told.overhang_bound_mm, static_cast<double>(stored.overhang_bound));
    EXPECT_LE(told.largest_growth_mm, 0.1 * told.overhang_bound_mm) << "certification only closes what is left";
  }
  EXPECT_GE(result.statistics.certified_pieces, mesh.triangles.size());
}

TEST(BuildSphereTree, EveryLevelIsCertified) {
  const Vector3d far(1e6, -1e6, 5e5);
  const TriangleMesh cube = test::boxMesh({0, 0, 0}, {2, 2, 2});
  const std::pair<const char*, TriangleMesh> meshes[] = {
      {"tetrahedron", tetrahedron()},
      {"cube", cube},
      {"sphere", test::sphereMesh(3, 3)},
      {"torus", test::torusMesh(5, 2, 24, 12)},
      {"thin plate", test::boxMesh({-10, -10, 0}, {10, 10, 0.05})},
      {"needle", test::boxMesh({0, 0, 0}, {100, 0.1, 0.1})},
      {"two components", test::joined(cube, test::moved(test::sphereMesh(1, 2), {5, 1, 0}))},
      {"far from the origin", test::moved(test::torusMesh(5, 2, 24, 12), far)},
      {"tiny", test::boxMesh({0, 0, 0}, {2e-6, 1e-6, 1e-6})},
  };
  for (const auto& [name, mesh] : meshes) {
    SCOPED_TRACE(name);
    expectCertified(mesh, build(mesh, quick()), quick());
  }
}

TEST(BuildSphereTree, EveryShapeOfTreeIsCertified) {
  const TriangleMesh mesh = test::torusMesh(5, 2, 16, 8);
  const std::pair<int, int> shapes[] = {{2, 2}, {2, 8}, {3, 2}, {3, 7}, {4, 3}, {5, 2}, {6, 2}, {4, 5}, {3, 8}};
  for (const auto& [levels, branching] : shapes) {
    SCOPED_TRACE(std::to_string(levels) + " levels of " + std::to_string(branching));
    const BuildSettings settings = quick(levels, branching);
    expectCertified(mesh, build(mesh, settings), settings);
  }
}

TEST(BuildSphereTree, FarFromTheOriginIsNoLooser) {
  const TriangleMesh near = test::torusMesh(5, 2, 24, 12);
  const BuildResult here = build(near, quick()), there = build(test::moved(near, {1e6, -1e6, 5e5}), quick());
  EXPECT_EQ(here.tree.origin_mm, (std::array<double, 3>{0, 0, 0}));
  EXPECT_NEAR(there.tree.origin_mm[0], 1e6, 1e-3);
  EXPECT_NEAR(there.statistics.levels.back().overhang_bound_mm, here.statistics.levels.back().overhang_bound_mm, 0.1);
}

TEST(BuildSphereTree, SameBytesForAnyNumberOfThreads) {
  const TriangleMesh mesh = test::torusMesh(5, 2, 24, 12);
  BuildSettings settings = quick(4, 4);
  settings.threads = 1;
  const std::vector<std::byte> one = encodeSphereTree(build(mesh, settings).tree);
  for (const int threads : {1, 2, 4, 0, 1024}) {
    settings.threads = threads;
    EXPECT_EQ(encodeSphereTree(build(mesh, settings).tree), one) << threads << " threads";
  }
  settings.seed = 2;
  EXPECT_NE(encodeSphereTree(build(mesh, settings).tree), one);
}

TEST(BuildSphereTree, RemembersWhereItComesFrom) {
  const TriangleMesh mesh = test::boxMesh({0, 0, 0}, {1, 2, 2});
  BuildSettings settings = quick(2, 4);
  settings.unit_mm = 25.4;
  settings.seed = 77;
  const Provenance from = build(mesh, settings).tree.provenance;
  EXPECT_EQ(from.builder, "cover");
  EXPECT_EQ(from.quality, "quick");
  EXPECT_EQ(from.unit_mm, 25.4);
  EXPECT_EQ(from.seed, 77u);
  EXPECT_EQ(from.triangle_count, 12u);
  EXPECT_NEAR(from.diagonal_mm, 3, 1e-12);
  EXPECT_NEAR(from.volume_mm3, 4, 1e-12);
  EXPECT_NEAR(from.area_mm2, 16, 1e-12);
  EXPECT_EQ(from.mesh_hash, meshHash(mesh));
  EXPECT_EQ(from.settings_hash, settingsHash(settings));
}

// A file holds no skin beyond 10 km: a mesh of that size is built without one, and that is said.
TEST(BuildSphereTree, TakesEverySizeThatTheCheckTakes) {
  for (const double size : {1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e7, 1e8, 1e9, 2e11}) {
    TriangleMesh mesh = tetrahedron();
    for (Vector3d& p : mesh.positions) p *= size;
    const BuildResult result = build(mesh, quick());
    EXPECT_EQ(findFault(result.tree), "") << size;
    EXPECT_EQ(result.tree.skin.empty(), size > 3e6) << size;
    EXPECT_EQ(result.statistics.notes.size(), size > 3e6 ? 1u : 0u) << size;
  }
}

TEST(BuildSphereTree, ToleranceIsKeptOrSaidToBeOutOfReach) {
  const TriangleMesh mesh = test::torusMesh(5, 2, 24, 12);
  BuildSettings settings = quick(4, 4);
  settings.tolerance_mm = 1.2;
  const BuildResult loose = build(mesh, settings);
  EXPECT_EQ(loose.statistics.tolerance_met, loose.statistics.levels.back().overhang_bound_mm <= 1.2);
  EXPECT_TRUE(loose.statistics.tolerance_met);
  EXPECT_LT(loose.statistics.levels.back().spheres, 64u);
  settings.tolerance_mm = 1e-3;
  const BuildResult tight = build(mesh, settings);
  EXPECT_FALSE(tight.statistics.tolerance_met);
  EXPECT_LE(tight.statistics.levels.back().spheres, 64u);
  settings.tolerance_mm = 0;
  EXPECT_EQ(tight.statistics.levels.back().spheres, build(mesh, settings).statistics.levels.back().spheres) << "the whole budget";
}

// If one sphere keeps the tolerance, the tree is that sphere: --levels is the largest number of levels, not the number
// to use. A cell that ended early is not the child of another cell: no cell may lose its last child because of it and
// so become a leaf of its part.
// Where the largest number of leaves is hardly more than what a tolerance needs, the tree has no more than it needs.
TEST(BuildSphereTree, ALimitNearTheNeededLeavesCostsNone) {
  for (const double wave : {0.2, 0.3, 0.35}) {
    TriangleMesh mesh = test::sphereMesh(5, 4);
    for (Vector3d& p : mesh.positions) p *= 1 + wave * std::sin(p.x()) * std::cos(1.3 * p.y()) + 0.05 * p.z();
    BuildSettings settings = quick(3, 8);  // at most 64 leaves
    settings.skin = false;
    settings.max_leaves = 60;
    settings.tolerance_mm = build(mesh, settings).statistics.levels.back().overhang_bound_mm;
    settings.max_leaves = 0;
    const BuildResult found = build(mesh, settings);
    EXPECT_TRUE(found.statistics.tolerance_met);
    EXPECT_LE(found.statistics.levels.back().spheres, 61u) << wave;
  }
}

TEST(BuildSphereTree, AnOctreeKeepsAToleranceThatAllOfItsCellsKeep) {
  const TriangleMesh mesh = test::torusMesh(5, 1, 24, 10);
  BuildSettings settings = quick(4, 8);
  settings.builder = BuilderKind::Octree;
  const double smallest = build(mesh, settings).statistics.levels.back().overhang_bound_mm;
  for (const double share : {1.05, 1.2, 1.5, 2.0}) {
    settings.tolerance_mm = share * smallest;
    const BuildResult result = build(mesh, settings);
    EXPECT_TRUE(result.statistics.tolerance_met) << share;
    EXPECT_LE(result.statistics.levels.back().overhang_bound_mm, settings.tolerance_mm);
  }
}

TEST(BuildSphereTree, ToleranceThatOneSphereKeepsGivesOneSphere) {
  const TriangleMesh mesh = test::torusMesh(5, 2, 24, 12);
  for (const BuilderKind kind : {BuilderKind::Cover, BuilderKind::Merge, BuilderKind::Grid, BuilderKind::Octree}) {
    BuildSettings settings = quick(4, 4);
    settings.builder = kind;
    settings.tolerance_mm = 50;
    const BuildResult result = build(mesh, settings);
    EXPECT_TRUE(result.statistics.tolerance_met) << name(kind);
    EXPECT_EQ(result.tree.nodeCount(), 1u) << name(kind);
    EXPECT_EQ(result.tree.levelCount(), 1) << name(kind);
    EXPECT_TRUE(result.tree.bound.empty()) << name(kind);
    EXPECT_EQ(findFault(result.tree), "") << name(kind);
  }
}

TEST(BuildSphereTree, RefusesSettingsOutOfRange) {
  const TriangleMesh mesh = test::boxMesh({0, 0, 0}, {1, 1, 1});
  const auto refused = [&](auto change) {
    BuildSettings settings = quick();
    change(settings);
    EXPECT_THROW(build(mesh, settings), std::invalid_argument);
  };
  for (const int levels : {-1, 0, 1, 7}) refused([&](BuildSettings& s) { s.levels = levels; });
  for (const int branching : {-1, 0, 1, 9}) refused([&](BuildSettings& s) { s.branching = branching; });
  for (const double tolerance : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()})
    refused([&](BuildSettings& s) { s.tolerance_mm = tolerance; });
  refused([](BuildSettings& s) { s.threads = -1; });
  refused([](BuildSettings& s) { s.builder = BuilderKind::Combined, s.combine = {BuilderKind::Cover}; });
}

TEST(BuildSphereTree, RefusesMeshesWithoutAnInside) {
  EXPECT_THROW(build({}, quick()), BuildError);
  EXPECT_THROW(build(test::boxMesh({0, 0, 0}, {1, 1, 0}), quick()), BuildError) << "flat";
  TriangleMesh inside_out = test::boxMesh({0, 0, 0}, {1, 1, 1});
  for (Triangle& t : inside_out.triangles) std::swap(t[1], t[2]);
  EXPECT_THROW(build(inside_out, quick()), BuildError);
}

TEST(BuildSphereTree, StopsWhenCancelledInAnyStage) {
  struct Stages : Progress {
    int left;
    void stage(std::string_view) override {
      if (left-- == 0) cancel();
    }
  };
  const TriangleMesh mesh = test::torusMesh(5, 2, 16, 8);
  for (int stage = 0; stage < 3; ++stage) {  // distances, cover, certify
    Stages progress;
    progress.left = stage;
    EXPECT_THROW(buildSphereTree(mesh, quick(), progress), Cancelled) << "stage " << stage;
  }
}

}  // namespace
}  // namespace spheretree::builder
