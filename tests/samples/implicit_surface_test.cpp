// SPDX-License-Identifier: GPL-3.0-or-later
#include "implicit_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "spheretree/builder/mesh_checks.h"

namespace spheretree::samples {
namespace {

using Eigen::Vector3d;

double ball(const Vector3d& p) { return p.norm() - 3; }

double torus(const Vector3d& p) {
  const double ring = std::sqrt(p.x() * p.x() + p.y() * p.y()) - 3;
  return std::sqrt(ring * ring + p.z() * p.z()) - 1;
}

TEST(ImplicitSurface, ABallComesOutClosedWithItsVolumeAndVerticesOnTheSphere) {
  const TriangleMesh mesh = polygonise(ball, Vector3d::Constant(-4), Vector3d::Constant(4), 0.3);
  const builder::MeshReport report = builder::checkMesh(mesh);
  EXPECT_TRUE(report.clean()) << report.summary();
  for (const Vector3d& p : mesh.positions) EXPECT_NEAR(p.norm(), 3, 1e-9);
  // Chords of length l cut off at most about l^2 / (4 r) of the radius.
  const double volume = 4.0 / 3 * std::numbers::pi * 27;
  EXPECT_LT(report.volume, volume);
  EXPECT_GT(report.volume, volume * (1 - 3 * 0.3 * 0.3 / (4 * 9)));
}

TEST(ImplicitSurface, ATorusKeepsItsHandle) {
  const TriangleMesh mesh = polygonise(torus, Vector3d(-5, -5, -2), Vector3d(5, 5, 2), 0.3);
  EXPECT_TRUE(builder::checkMesh(mesh).clean());
  const auto edges = static_cast<long>(mesh.triangles.size()) * 3 / 2;
  EXPECT_EQ(static_cast<long>(mesh.positions.size()) - edges + static_cast<long>(mesh.triangles.size()), 0);
}

TEST(ImplicitSurface, TrianglesAreWellShaped) {
  const TriangleMesh mesh = polygonise(torus, Vector3d(-5, -5, -2), Vector3d(5, 5, 2), 0.3);
  double min_cosine = -1;  // of the smallest angle
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const Vector3d u = mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k), v = mesh.corner(t, (k + 2) % 3) - mesh.corner(t, k);
      min_cosine = std::max(min_cosine, u.dot(v) / (u.norm() * v.norm()));
    }
  }
  EXPECT_LT(min_cosine, std::cos(25 * std::numbers::pi / 180));
}

TEST(ImplicitSurface, RefusesASolidThatReachesOutOfItsBox) {
  EXPECT_THROW(polygonise(ball, Vector3d(-4, -4, -2), Vector3d(4, 4, 4), 0.5), std::invalid_argument);
}

TEST(ImplicitSurface, SmoothMaximumIsSymmetricAndClose) {
  for (double b = -2; b <= 2; b += 0.125) {
    EXPECT_EQ(smoothMax(0.5, b, 0.8), smoothMax(b, 0.5, 0.8));
    EXPECT_GE(smoothMax(0.5, b, 0.8), std::max(0.5, b));
    EXPECT_LE(smoothMax(0.5, b, 0.8), std::max(0.5, b) + 0.2 + 1e-15);
    EXPECT_EQ(smoothMin(0.5, b, 0.8), -smoothMax(-0.5, -b, 0.8));
    if (std::abs(b - 0.5) >= 0.8) {
      EXPECT_EQ(smoothMax(0.5, b, 0.8), std::max(0.5, b));
    }
  }
  EXPECT_EQ(smoothStep(-1), 0);
  EXPECT_EQ(smoothStep(0.5), 0.5);
  EXPECT_EQ(smoothStep(2), 1);
}

}  // namespace
}  // namespace spheretree::samples
