// SPDX-License-Identifier: GPL-3.0-or-later
#include "measure/lower_bound.h"

#include <gtest/gtest.h>

#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/builder/evaluate_tree.h"
#include "spheretree/core/mesh_edit.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

// The largest admissible ball about an inner point of a box has the radius of the inscribed ball plus the overhang.
TEST(LowerBound, NoAdmissibleBallOfABoxHoldsMoreThanOne) {
  const TriangleMesh box = test::boxMesh({0, 0, 0}, {8, 6, 1});
  const DistanceField field(box);
  Progress progress;
  const LowerBound bound(box, field, 30, 1, progress);
  std::mt19937_64 random(7);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  for (const double overhang : {0.15, 0.4}) {
    const LowerBound::Weights weights = bound.weights(overhang, progress);
    EXPECT_GT(weights.total, 4);
    double fullest = 0;
    for (int k = 0; k < 20000; ++k) {
      const Vector3d c(8 * unit(), 6 * unit(), k % 2 ? 0.5 : unit());
      double held = 0;
      bound.points().within(c, -field.signedDistance(c) + overhang, [&](std::size_t slot, double) { held += weights.weight[slot]; });
      fullest = std::max(fullest, held);
    }
    EXPECT_LE(fullest, 1);
    EXPECT_GT(fullest, 0.7);  // no trial shows anything if no ball comes near
  }
}

// The hexagonal lattice covers a slab with the fewest balls (Kershner): n 2 pi s (1 + s) = 1.2092 A for thickness 1.
TEST(LowerBound, SlabStaysBelowTheHexagonalLattice) {
  const TriangleMesh slab = test::boxMesh({0, 0, 0}, {30, 30, 1});
  const DistanceField field(slab);
  Progress progress;
  const LowerBound bound(slab, field, 250, 1, progress);
  for (const double s : {0.5, 0.8}) {
    const double lattice = 1.2091995761561452 * 2 * 30 * 30 / (2 * std::numbers::pi * s * (1 + s));
    const double needed = bound.spheresNeeded(s, progress);
    EXPECT_LT(needed, lattice);
    EXPECT_GT(needed, 0.5 * lattice);
  }
}

// From a centre beside a crack, the line through the nearest surface point leads through the crack and along the plate:
// what bounds the ball is found elsewhere.
TEST(LowerBound, CracksDoNotLowerIt) {
  constexpr double kOverhang = 0.3;
  const TriangleMesh plate = test::boxMesh({0, 0, 0}, {12, 6, 1});
  TriangleMesh cracked = plate;
  for (int x = 1; x < 12; ++x) {
    TriangleMesh crack = test::boxMesh({x - 0.01, 0.1, 0.1}, {x + 0.01, 5.9, 0.9});
    for (Triangle& t : crack.triangles) std::swap(t[0], t[1]);
    cracked = joined(std::move(cracked), crack);
  }
  Progress progress;
  const DistanceField plain_field(plate), cracked_field(cracked);
  const double plain = LowerBound(plate, plain_field, 40, 1, progress).spheresNeeded(kOverhang, progress);
  EXPECT_GT(LowerBound(plate, cracked_field, 40, 1, progress).spheresNeeded(kOverhang, progress), 0.8 * plain);
}

TEST(LowerBound, OneBallCoversASphere) {
  const TriangleMesh ball = test::sphereMesh(2, 3);
  const DistanceField field(ball);
  Progress progress;
  double radius = 0;
  for (const Vector3d& p : ball.positions) radius = std::max(radius, p.norm());
  const double overhang = radius + field.signedDistance(Vector3d::Zero());
  EXPECT_LE(LowerBound(ball, field, 1, 1, progress).spheresNeeded(overhang * (1 + 1e-6), progress), 1);
}

TEST(LowerBound, RefusesNoSpheres) {
  const TriangleMesh box = test::boxMesh({0, 0, 0}, {1, 1, 1});
  const DistanceField field(box);
  Progress progress;
  EXPECT_THROW(LowerBound(box, field, 0, 1, progress), std::invalid_argument);
}

// Six balls about the centres of the parts of a rod cover it: their overhang is no less than what is proven.
TEST(LowerBound, NeverExceedsTheOverhangOfACover) {
  Progress progress;
  for (const int parts : {2, 3, 6}) {
    const TriangleMesh rod = test::boxMesh({0, 0, 0}, {6, 1, 1});
    const DistanceField field(rod);
    const double half = 3.0 / parts, radius = std::sqrt(half * half + 0.5);
    const double overhang = radius - 0.5;
    const LowerBound bound(rod, field, static_cast<std::size_t>(parts), 1, progress);
    EXPECT_LE(bound.spheresNeeded(overhang * (1 + 1e-9), progress), parts);
    const ProvenLimit limit = provenLimit(bound, static_cast<std::size_t>(parts), overhang, progress);
    EXPECT_GT(limit.overhang, 0);
    EXPECT_LE(limit.overhang, overhang);
  }
}

// No tree has fewer leaves than its overhang needs at least, whichever builder made it, and for any number of threads.
TEST(LowerBound, NoBuilderGoesBelow) {
  const TriangleMesh torus = test::torusMesh(3, 1, 24, 12);
  Progress progress;
  for (const BuilderKind kind : {BuilderKind::Cover, BuilderKind::Merge, BuilderKind::Grid, BuilderKind::Octree}) {
    BuildSettings settings;
    settings.builder = kind, settings.levels = 3, settings.quality = Quality::Quick, settings.skin = false;
    const LevelBuildStatistics leaves = buildSphereTree(torus, settings, progress).statistics.levels.back();
    std::size_t least[2];
    for (const int threads : {1, 2})
      least[threads - 1] =
          tbb::task_arena(threads).execute([&] { return leastSpheres(torus, leaves.overhang_bound_mm, leaves.spheres, 1, progress); });
    EXPECT_EQ(least[0], least[1]);
    EXPECT_LE(least[0], leaves.spheres) << static_cast<int>(kind);
    if (kind == BuilderKind::Cover) {
      EXPECT_GT(4 * least[0], leaves.spheres);
    }
  }
}

}  // namespace
}  // namespace spheretree::builder
