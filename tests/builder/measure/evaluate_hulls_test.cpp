// SPDX-License-Identifier: GPL-3.0-or-later
#include "measure/evaluate_hulls.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

#include "support/sample_hulls.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

// A rod with round ends along z, with vertices on its surface.
TriangleMesh rodMesh(double radius, double length, const Vector3d& at) {
  TriangleMesh mesh = test::sphereMesh(radius, 4);
  for (Vector3d& p : mesh.positions) p += at + Vector3d(0, 0, p.z() > 1e-9 ? length : 0);
  return mesh;
}

HullEvaluation evaluate(const TriangleMesh& mesh, const Hulls& hulls, const Vector3d& origin) {
  Progress progress;
  return evaluateHulls(mesh, DistanceField(mesh), hulls, origin, {.count = 20000}, progress);
}

// Facets lie inside the rod by at most the sagitta, so that the overhang of a rod that is thicker by x lies between x
// and x plus that.
TEST(EvaluateHulls, AKnownOverhangAndNothingBare) {
  const Vector3d origin(3, -4, 5);
  const TriangleMesh mesh = rodMesh(1, 6, origin);
  const double sagitta = 0.01, excess = 0.05;
  Hulls hulls = test::rodHulls({0, 0, 0}, 1 + excess, {0, 0, 6}, 1 + excess);
  hulls.overhang_bound = 0.07f;
  const HullEvaluation figures = evaluate(mesh, hulls, origin);
  EXPECT_EQ(figures.hulls, 1u);
  EXPECT_EQ(figures.parts, hulls.parts.size());
  EXPECT_EQ(figures.balls, hulls.balls.size());
  EXPECT_EQ(figures.samples, 20000u);
  EXPECT_EQ(figures.bare_samples, 0u);
  EXPECT_EQ(figures.max_gap, 0);
  EXPECT_GE(figures.overhang_max, excess - 1e-6);
  EXPECT_LE(figures.overhang_max, excess + sagitta);
  EXPECT_EQ(figures.overhang_bound, double{hulls.overhang_bound});
}

// The cap and most of the side beyond the end of a rod that is too short by its radius are bare, and the pole is the
// farthest point.
TEST(EvaluateHulls, WhatIsMissingIsFoundWithItsDistance) {
  const TriangleMesh mesh = rodMesh(1, 2, Vector3d::Zero());
  const HullEvaluation figures = evaluate(mesh, test::rodHulls({0, 0, 0}, 1.02, {0, 0, 1}, 1.02), Vector3d::Zero());
  EXPECT_NEAR(figures.max_gap, 2 + 1 - 1 - 1.02, 0.01);
  // The end ball holds the side of radius 1 up to sqrt(1.02^2 - 1) beyond its centre.
  const double pi = std::numbers::pi, area = 4 * pi + 2 * pi * 2, missing = 2 * pi + 2 * pi * (1 - std::sqrt(1.02 * 1.02 - 1));
  EXPECT_NEAR(static_cast<double>(figures.bare_samples) / 20000, missing / area, 0.01);
}

TEST(EvaluateHulls, TheSameForAnyNumberOfThreads) {
  const TriangleMesh mesh = rodMesh(1, 2, Vector3d::Zero());
  const auto with = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return evaluate(mesh, test::rodHulls({0, 0, 0}, 1.02, {0, 0, 1}, 1.02), Vector3d::Zero());
  };
  const HullEvaluation one = with(1), four = with(4);
  EXPECT_EQ(one.bare_samples, four.bare_samples);
  EXPECT_EQ(one.max_gap, four.max_gap);
  EXPECT_EQ(one.overhang_max, four.overhang_max);
}

}  // namespace
}  // namespace spheretree::builder
