// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/simplify_mesh.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/builder/mesh_checks.h"
#include "spheretree/builder/provenance.h"
#include "support/dense_points.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

TriangleMesh simplified(const TriangleMesh& mesh, std::size_t triangles) {
  Progress progress;
  return simplifyMesh(mesh, triangles, progress);
}

double boundTo(const TriangleMesh& mesh, const TriangleMesh& other) {
  Progress progress;
  return distanceBound(mesh, DistanceField(other), progress);
}

double largestDistance(const TriangleMesh& mesh, const TriangleMesh& other, int inner) {
  const DistanceField field(other);
  double largest = 0;
  for (const Vector3d& p : test::densePoints(mesh, inner, 5)) largest = std::max(largest, field.distance(p));
  return largest;
}

TEST(SimplifyMesh, TheResultIsSoundAndOfTheSizeAskedFor) {
  for (const TriangleMesh& mesh : {test::sphereMesh(5, 5), test::torusMesh(10, 3, 80, 50)}) {
    const std::size_t wanted = mesh.triangles.size() / 10;
    const TriangleMesh coarse = simplified(mesh, wanted);
    const MeshReport before = checkMesh(mesh), after = checkMesh(coarse);
    EXPECT_TRUE(after.clean()) << after.summary();
    EXPECT_LE(coarse.triangles.size(), wanted + 2);
    EXPECT_NEAR(after.volume, before.volume, 0.03 * before.volume);
    std::size_t v = 0;  // a subset of the vertices, in their order
    for (const Vector3d& p : coarse.positions) {
      while (v < mesh.positions.size() && mesh.positions[v] != p) ++v;
      ASSERT_LT(v, mesh.positions.size());
    }
  }
}

TEST(SimplifyMesh, FlatFacesCostNothing) {
  TriangleMesh grid = test::boxMesh({-1, -2, -3}, {4, 5, 6});
  for (int round = 0; round < 4; ++round) grid = test::quartered(grid);
  const TriangleMesh coarse = simplified(grid, 100);
  EXPECT_LE(coarse.triangles.size(), 100u);
  EXPECT_LT(boundTo(grid, coarse), 2e-5) << "a box of 3072 triangles is a box of 100";
  EXPECT_NEAR(checkMesh(coarse).volume, 5 * 7 * 9, 1e-9);
}

TEST(SimplifyMesh, SliversOfACylinderBecomeWideFacets) {
  constexpr std::uint32_t kSectors = 4000;  // facets of 1.6 um by 3 mm, and two fans
  TriangleMesh cylinder;
  cylinder.positions = {{0, 0, 0}, {0, 0, 3}};
  for (std::uint32_t i = 0; i < kSectors; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSectors;
    for (const double z : {0.0, 3.0}) cylinder.positions.emplace_back(std::cos(angle), std::sin(angle), z);
    const std::uint32_t a = 2 + 2 * i, b = 2 + 2 * ((i + 1) % kSectors);
    cylinder.triangles.insert(cylinder.triangles.end(), {{a, b, b + 1}, {a, b + 1, a + 1}, {0, b, a}, {1, a + 1, b + 1}});
  }
  Progress progress;
  const TriangleMesh coarse = simplifyMesh(cylinder, 400, progress, 0.01);
  EXPECT_LT(coarse.triangles.size(), 1000u);
  EXPECT_LT(boundTo(cylinder, coarse), 0.02);
  EXPECT_LT(distanceBound(coarse, DistanceField(cylinder), progress, 0.02), 0.02);
}

TEST(SimplifyMesh, StepsGoOnFromEachOther) {
  const TriangleMesh mesh = test::torusMesh(10, 3, 80, 50);
  Progress progress;
  MeshSimplifier simplifier(mesh, progress);
  const TriangleMesh fine = simplifier.reduce(100, 0.02), coarse = simplifier.reduce(100, 0.05), coarsest = simplifier.reduce(400);
  EXPECT_GT(fine.triangles.size(), coarse.triangles.size());
  EXPECT_GT(coarse.triangles.size(), coarsest.triangles.size());
  EXPECT_NEAR(static_cast<double>(coarsest.triangles.size()), 400, 2);
  EXPECT_LT(boundTo(mesh, fine), boundTo(mesh, coarse));
  EXPECT_LT(boundTo(mesh, coarsest), 1.2 * boundTo(mesh, simplified(mesh, 400))) << "as good as in one step";
  EXPECT_TRUE(checkMesh(coarsest).clean());
}

TEST(SimplifyMesh, ASufficientBoundIsKeptOrRefused) {
  // Sheets beside each other at a height that is the sufficient bound, but for rounding that the position makes large.
  Progress progress;
  for (const double share : {0.9, 1 - 1e-9, 1 - 1e-11, 1.0, 1.1}) {
    TriangleMesh low = test::boxMesh({1e4, 1e4, 1e4}, {1e4 + 5, 1e4 + 5, 1e4 + 5}), high = low;
    for (Vector3d& p : high.positions) p.x() += 0.01 * share;
    const double bound = distanceBound(high, DistanceField(low), progress, 0.01);
    EXPECT_TRUE(bound <= 0.01 || bound == kInfinity) << share << ": " << bound - 0.01;
    EXPECT_EQ(bound <= 0.01, share < 1 - 1e-7) << share;
  }
}

TEST(SimplifyMesh, TheBoundHoldsAndIsTight) {
  for (const TriangleMesh& mesh : {test::sphereMesh(5, 5), test::torusMesh(10, 3, 80, 50)}) {
    const TriangleMesh coarse = simplified(mesh, mesh.triangles.size() / 8);
    const double found = largestDistance(mesh, coarse, 4), bound = boundTo(mesh, coarse);
    EXPECT_GE(bound, found);
    EXPECT_LE(bound, 1.3 * found);
    EXPECT_LE(bound, 0.3) << "triangles are 1 mm wide here";
  }
}

// A ball of few triangles in one of many: its vertices are on it, and only its middles tell how far it is.
TEST(SimplifyMesh, TheBoundIsTightWhereALooseOneSuffices) {
  const TriangleMesh ball = test::sphereMesh(5, 4), coarse = simplified(ball, 24);
  const double found = largestDistance(coarse, ball, 20);
  Progress progress;
  for (const double sufficient : {1.4 * found, 2 * found, 3 * found}) {
    const double bound = distanceBound(coarse, DistanceField(ball), progress, sufficient);
    EXPECT_GE(bound, found);
    EXPECT_LE(bound, 1.3 * found) << sufficient / found;
  }
}

// A stepped shaft: along its creases the coarse triangles are chords of the fine rings, and along their normals the
// next wall lies over them, far away.
TEST(SimplifyMesh, TheBoundIsTightAlongCreases) {
  const auto shaft = [](std::uint32_t sectors) {
    TriangleMesh mesh;
    mesh.positions = {{0, 0, 0}, {0, 0, 2}};
    for (std::uint32_t i = 0; i < sectors; ++i)
      for (const auto& [radius, z] : {std::pair(1.0, 0.0), {1.0, 1.0}, {2.0, 1.0}, {2.0, 2.0}}) {
        const double angle = 2 * std::numbers::pi * i / sectors;
        mesh.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
      }
    for (std::uint32_t i = 0; i < sectors; ++i) {
      const std::uint32_t a = 2 + 4 * i, b = 2 + 4 * ((i + 1) % sectors);
      mesh.triangles.insert(mesh.triangles.end(), {{0, b, a}, {1, a + 3, b + 3}});
      for (std::uint32_t k = 0; k < 3; ++k)
        mesh.triangles.insert(mesh.triangles.end(), {{a + k, b + k, b + k + 1}, {a + k, b + k + 1, a + k + 1}});
    }
    return mesh;
  };
  const TriangleMesh fine = shaft(800), coarse = shaft(40);
  ASSERT_TRUE(checkMesh(fine).clean());
  const double found = largestDistance(coarse, fine, 20);
  EXPECT_NEAR(found, 2 * (1 - std::cos(std::numbers::pi / 40)), 1e-4) << "the middle of a chord of the larger ring";
  Progress progress;
  for (const double sufficient : {1.2 * found, 1.5 * found, 4 * found}) {
    const double bound = distanceBound(coarse, DistanceField(fine), progress, sufficient);
    EXPECT_GE(bound, found);
    EXPECT_LE(bound, std::min(1.26 * found, sufficient)) << sufficient / found;
  }
}

TEST(SimplifyMesh, TheBoundSeesWhatNoVertexTells) {
  // The corners of the box lie on the sphere; the middles of its sides are far from it.
  const double half = 5 / std::sqrt(3.0);
  const TriangleMesh box = test::quartered(test::quartered(test::boxMesh(Vector3d::Constant(-half), Vector3d::Constant(half)))),
                     ball = test::sphereMesh(5, 5);
  EXPECT_GE(boundTo(box, ball), (5 - half) * 0.98);
  EXPECT_LE(boundTo(box, ball), (5 - half) * 1.3);
  EXPECT_NEAR(boundTo(test::sphereMesh(5.5, 5), ball), 0.5, 0.13) << "concentric";
}

TEST(SimplifyMesh, SameTrianglesForAnyNumberOfThreads) {
  const TriangleMesh mesh = test::torusMesh(10, 3, 80, 50);
  const TriangleMesh two = simplified(mesh, 900);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const TriangleMesh one = simplified(mesh, 900);
  EXPECT_EQ(meshHash(one), meshHash(two));
}

TEST(SimplifyMesh, RefusesNonManifoldMeshesAndCanBeCancelled) {
  TriangleMesh fin = test::boxMesh({0, 0, 0}, {1, 1, 1});
  fin.triangles.push_back({0, 3, 6});
  EXPECT_THROW(simplified(fin, 4), std::invalid_argument);
  Progress progress;
  progress.cancel();
  EXPECT_THROW(simplifyMesh(test::sphereMesh(1, 3), 100, progress), Cancelled);
}

TEST(SimplifyMesh, ABuildOnFewerTrianglesIsProvenAgainstAll) {
  const TriangleMesh mesh = test::torusMesh(10, 3, 210, 110);  // 46,200 triangles; the search takes 20,000
  BuildSettings settings;
  settings.quality = Quality::Quick;
  settings.levels = 2;
  settings.branching = 8;
  Progress progress;
  const BuildResult result = buildSphereTree(mesh, settings, progress);
  const Simplification& simplification = result.statistics.simplification;
  EXPECT_GT(simplification.triangles, 15'000u);
  EXPECT_LE(simplification.triangles, 20'002u);
  EXPECT_LT(simplification.distance_bound_mm, 0.02);
  EXPECT_EQ(result.tree.provenance.triangle_count, mesh.triangles.size());
  EXPECT_EQ(result.tree.provenance.mesh_hash, meshHash(mesh));

  const DistanceField field(mesh);
  const std::vector<Vector3d> points = test::densePoints(mesh, 2, 11);
  test::Random random(3);
  for (int level = 0; level < result.tree.levelCount(); ++level) {
    std::vector<Sphere> spheres;
    for (const std::uint32_t node : levelSet(result.tree, level)) spheres.push_back(result.tree.cover[node]);
    const std::vector<Ball> balls = test::toBalls(spheres);
    EXPECT_LE(test::largestGap(points, balls), 1e-14) << "level " << level;
    for (const Ball& b : balls)
      for (int i = 0; i < 200; ++i)
        EXPECT_LE(field.signedDistance(b.centre + b.radius * random.direction()),
                  result.statistics.levels[static_cast<std::size_t>(level)].overhang_bound_mm);
  }

  BuildSettings whole = settings;
  whole.simplify = false;
  const BuildResult exact = buildSphereTree(mesh, whole, progress);
  EXPECT_EQ(exact.statistics.simplification.triangles, 0u);
  EXPECT_NE(exact.tree.provenance.settings_hash, result.tree.provenance.settings_hash);
  EXPECT_NEAR(result.statistics.levels.back().overhang_bound_mm, exact.statistics.levels.back().overhang_bound_mm,
              0.1 * exact.statistics.levels.back().overhang_bound_mm);

  settings.tolerance_mm = 10 * simplification.distance_bound_mm;
  EXPECT_EQ(buildSphereTree(mesh, settings, progress).statistics.simplification.triangles, 0u) << "it would use up too much of it";
  settings.tolerance_mm = 2 * result.statistics.levels.back().overhang_bound_mm;
  const BuildResult within = buildSphereTree(mesh, settings, progress);
  EXPECT_GT(within.statistics.simplification.triangles, 0u);
  EXPECT_TRUE(within.statistics.tolerance_met);
}

}  // namespace
}  // namespace spheretree::builder
