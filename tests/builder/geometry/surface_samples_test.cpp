// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/surface_samples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/distance_field.h"
#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

bool same(const std::vector<SurfaceSample>& a, const std::vector<SurfaceSample>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const SurfaceSample& s, const SurfaceSample& t) {
    return s.point == t.point && s.normal == t.normal && s.triangle == t.triangle && s.feature == t.feature;
  });
}

TEST(SurfaceSamples, LieOnTheirTriangleWithItsNormal) {
  for (const TriangleMesh& mesh : {test::torusMesh(5, 2, 24, 12), test::boxMesh({-1, 2, 3}, {4, 3, 3.5})}) {
    const DistanceField field(mesh);
    for (const SurfaceSample& s : sampleSurface(mesh, {2000, 0.5235987756, 3})) {
      ASSERT_LT(s.triangle, mesh.triangles.size());
      const auto [a, b, c] = field.corners(s.triangle);
      EXPECT_LT(nearestOnTriangle(s.point, a, b, c).distance, 1e-12);
      EXPECT_NEAR(s.normal.norm(), 1, 1e-12);
      if (!s.feature) {
        EXPECT_LT((s.normal - field.normal(s.triangle)).norm(), 1e-9);
      }
      EXPECT_GT(s.normal.dot(field.normal(s.triangle)), 0.4) << "outward, at features too";
    }
  }
}

// One sample in each of `count` equal shares of the area: a triangle of k shares gets more than k - 2 and fewer than k
// + 2 samples, whereas independent points would deviate by sqrt(k).
TEST(SurfaceSamples, EveryTriangleGetsItsShareOfTheArea) {
  const TriangleMesh mesh = test::boxMesh({0, 0, 0}, {10, 3, 1});
  const std::size_t count = 5000;
  std::vector<double> got(mesh.triangles.size(), 0);
  for (const SurfaceSample& s : sampleSurface(mesh, {count, 0.5235987756, 9}))
    if (!s.feature) ++got[s.triangle];
  const DistanceField field(mesh);
  for (std::size_t t = 0; t < got.size(); ++t) {
    const double area = 0.5 * (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
    EXPECT_LT(std::abs(got[t] - area / field.area() * static_cast<double>(count)), 2) << "triangle " << t;
  }
}

// Uniform within a triangle: first and second moments about the centroid, to five standard errors.
TEST(SurfaceSamples, AreUniformWithinATriangle) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  const double n = 40000;
  double x = 0, y = 0, xx = 0, xy = 0;
  for (const SurfaceSample& s : sampleSurface(mesh, {static_cast<std::size_t>(n), 0.5235987756, 4})) {
    x += s.point.x() / n;
    y += s.point.y() / n;
    xx += s.point.x() * s.point.x() / n;
    xy += s.point.x() * s.point.y() / n;
  }
  EXPECT_NEAR(x, 1.0 / 3, 0.006);
  EXPECT_NEAR(y, 1.0 / 3, 0.006);
  EXPECT_NEAR(xx, 1.0 / 6, 0.005);
  EXPECT_NEAR(xy, 1.0 / 12, 0.002);
}

TEST(SurfaceSamples, FeaturesOfACubeAreItsCornersAndItsEdges) {
  const TriangleMesh cube = test::boxMesh({0, 0, 0}, {1, 1, 1});
  const std::size_t count = 600;
  const double spacing = std::sqrt(6.0 / count);
  std::vector<Vector3d> features;
  for (const SurfaceSample& s : sampleSurface(cube, {count, 0.5235987756, 1}))
    if (s.feature) features.push_back(s.point);
  for (const Vector3d& corner : cube.positions) EXPECT_EQ(std::count(features.begin(), features.end(), corner), 1);
  for (const Vector3d& p : features) {
    int on = 0;  // faces that it lies on; a point on the diagonal of a face would have one
    for (int axis = 0; axis < 3; ++axis) on += std::min(std::abs(p[axis]), std::abs(1 - p[axis])) < 1e-12;
    EXPECT_GE(on, 2) << p.transpose();
  }
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 4; ++side)
      for (double t = 0; t <= 1; t += 0.01) {
        Vector3d p;
        p[axis] = t;
        p[(axis + 1) % 3] = side & 1;
        p[(axis + 2) % 3] = side >> 1;
        double nearest = 1;
        for (const Vector3d& f : features) nearest = std::min(nearest, (f - p).norm());
        EXPECT_LE(nearest, 0.5 * spacing + 1e-9) << p.transpose();
      }
  EXPECT_LT(features.size(), 1.1 * 12 / spacing + 8) << "no more than one a spacing";
}

TEST(SurfaceSamples, SmoothSurfaceHasNoFeatures) {
  const TriangleMesh mesh = test::sphereMesh(1, 4);
  for (const SurfaceSample& s : sampleSurface(mesh, {1000, 0.5235987756, 1})) EXPECT_FALSE(s.feature);
}

TEST(SurfaceSamples, FeaturesOfARoughSurfaceAreAtMostHalfAsMany) {
  TriangleMesh mesh = test::sphereMesh(1, 4);
  test::Random random(5);
  for (Vector3d& p : mesh.positions) p *= random.between(0.8, 1.2);
  const std::vector<SurfaceSample> samples = sampleSurface(mesh, {1000, 0.5235987756, 1});
  EXPECT_EQ(std::count_if(samples.begin(), samples.end(), [](const SurfaceSample& s) { return s.feature; }), 500);
  EXPECT_EQ(samples.size(), 1500u);
}

TEST(SurfaceSamples, SeedDecidesAll) {
  const TriangleMesh mesh = test::torusMesh(5, 2, 12, 8);
  const auto one = sampleSurface(mesh, {500, 0.5235987756, 1});
  EXPECT_TRUE(same(one, sampleSurface(mesh, {500, 0.5235987756, 1})));
  EXPECT_FALSE(same(one, sampleSurface(mesh, {500, 0.5235987756, 2})));
}

TEST(SurfaceSamples, NothingToSampleGivesNone) {
  EXPECT_TRUE(sampleSurface(test::sphereMesh(1, 1), {0, 0.5235987756, 1}).empty());
  EXPECT_TRUE(sampleSurface(test::boxMesh({1, 1, 1}, {1, 1, 1}), {100, 0.5235987756, 1}).empty());
  EXPECT_TRUE(sampleSurface({}, {100, 0.5235987756, 1}).empty());
}

}  // namespace
}  // namespace spheretree::builder
