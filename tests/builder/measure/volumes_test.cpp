// SPDX-License-Identifier: GPL-3.0-or-later
#include "measure/volumes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "geometry/distance_field.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

constexpr std::size_t kLines = 512 * 512;

Volumes volumesOf(const TriangleMesh& mesh, const std::vector<Ball>& balls) {
  Progress progress;
  return measureVolumes(mesh, balls, kLines, progress);
}

double ballVolume(double r) { return 4 * pi / 3 * r * r * r; }

/// The volume of the intersection of two balls of radius r whose centres are d apart.
double lensVolume(double r, double d) { return pi * (2 * r - d) * (2 * r - d) * (4 * r + d) / 12; }

TEST(Volumes, MeshAloneHasItsOwnVolume) {
  for (const TriangleMesh& mesh : {test::boxMesh({5, 5, 5}, {6, 8, 5.5}), test::sphereMesh(3, 3), test::torusMesh(2, 0.5, 30, 12)}) {
    const Volumes volumes = volumesOf(mesh, {});
    const double exact = DistanceField(mesh).volume();
    EXPECT_NEAR(volumes.mesh, exact, 1e-4 * exact);
    EXPECT_EQ(volumes.missing, volumes.mesh);
    EXPECT_EQ(volumes.balls, 0);
  }
}

TEST(Volumes, UnionOfTwoBallsIsTheClosedForm) {
  const TriangleMesh cube = test::boxMesh({-3, -3, -3}, {3, 3, 3});
  for (const double d : {0.3, 1.0, 1.9}) {
    const Volumes volumes = volumesOf(cube, {{{0, 0, 0}, 1}, {d * Vector3d(1, 2, 2) / 3, 1}});
    const double exact = 2 * ballVolume(1) - lensVolume(1, d);
    EXPECT_NEAR(volumes.balls, exact, 1e-3 * exact);
    EXPECT_NEAR(volumes.excess, 0, 1e-12);
    EXPECT_NEAR(volumes.missing, 216 - exact, 1e-3 * exact);
  }
}

TEST(Volumes, BallThroughTheFacesOfACube) {
  const double r = 1.3, h = r - 1, cap = pi * h * h * (3 * r - h) / 3;  // one cap sticks out of each face
  const Volumes volumes = volumesOf(test::boxMesh({-1, -1, -1}, {1, 1, 1}), {{{0, 0, 0}, r}});
  EXPECT_NEAR(volumes.excess, 6 * cap, 1e-3 * cap);
  EXPECT_NEAR(volumes.missing, 8 - (ballVolume(r) - 6 * cap), 1e-3);
  EXPECT_NEAR(volumes.mesh, 8, 1e-3);
}

TEST(Volumes, OverlappingPartsCountOnceAndCavitiesDoNot) {
  const TriangleMesh pair = test::joined(test::boxMesh({0, 0, 0}, {2, 1, 1}), test::boxMesh({1, 0, 0}, {3, 1, 1}));
  EXPECT_NEAR(volumesOf(pair, {}).mesh, 3, 1e-3);
  TriangleMesh hole = test::boxMesh({1, 1, 1}, {2, 2, 2});
  for (Triangle& t : hole.triangles) std::swap(t[1], t[2]);
  const Volumes hollow = volumesOf(test::joined(test::boxMesh({0, 0, 0}, {3, 3, 3}), hole), {{{1.5, 1.5, 1.5}, 0.4}});
  EXPECT_NEAR(hollow.mesh, 26, 1e-3 * 26);
  EXPECT_NEAR(hollow.excess, ballVolume(0.4), 1e-3) << "a ball in the cavity is outside";
}

TEST(Volumes, DoNotDependOnWhereTheObjectIs) {
  const TriangleMesh near = test::torusMesh(2, 0.5, 30, 12);
  TriangleMesh far = near;
  for (Vector3d& p : far.positions) p += Vector3d(1e6, -2e6, 3e6);
  const Volumes a = volumesOf(near, {{{2, 0, 0}, 0.6}}), b = volumesOf(far, {{{1e6 + 2, -2e6, 3e6}, 0.6}});
  EXPECT_NEAR(a.mesh, b.mesh, 1e-5);
  EXPECT_NEAR(a.excess, b.excess, 1e-5);
  EXPECT_NEAR(a.missing, b.missing, 1e-5);
}

TEST(Volumes, OpenMeshGivesFiniteNumbers) {
  TriangleMesh open = test::sphereMesh(1, 2);
  open.triangles.resize(open.triangles.size() / 2);
  const Volumes volumes = volumesOf(open, {{{0, 0, 0}, 1.1}});
  EXPECT_TRUE(std::isfinite(volumes.mesh));
  EXPECT_LE(volumes.mesh, ballVolume(1.1));
  Progress progress;
  EXPECT_THROW(measureVolumes(open, {}, 0, progress), std::invalid_argument);
}

}  // namespace
}  // namespace spheretree::builder
