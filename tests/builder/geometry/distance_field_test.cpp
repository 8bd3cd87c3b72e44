// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/distance_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

/// An independent computation in long double: the foot of the perpendicular if it is inside all three sides, otherwise
/// the nearest side.
double triangleDistance(const Vector3d& point, const Vector3d& ca, const Vector3d& cb, const Vector3d& cc) {
  using Vector = Eigen::Matrix<long double, 3, 1>;
  const Vector p = point.cast<long double>();
  const std::array<Vector, 3> corner{ca.cast<long double>(), cb.cast<long double>(), cc.cast<long double>()};
  const Vector normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
  bool within = normal.squaredNorm() > 0;
  long double best = std::numeric_limits<long double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector side = corner[(k + 1) % 3] - corner[k], w = p - corner[k];
    within = within && normal.dot(side.cross(w)) >= 0;
    const long double length2 = side.squaredNorm();
    const long double t = length2 > 0 ? std::clamp(w.dot(side) / length2, 0.0L, 1.0L) : 0.0L;
    best = std::min(best, (w - t * side).norm());
  }
  if (within) best = std::min(best, std::abs(normal.dot(p - corner[0])) / normal.norm());
  return static_cast<double>(best);
}

/// Winding number by solid angles. Paper: A. van Oosterom, J. Strackee, IEEE Trans. Biomed. Eng. 30, 1983.
double windingNumber(const TriangleMesh& mesh, const Vector3d& p) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vector3d a = mesh.corner(t, 0) - p, b = mesh.corner(t, 1) - p, c = mesh.corner(t, 2) - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (4 * std::numbers::pi);
}

TEST(NearestOnTriangle, DistanceIsTheOneOfTheOracle) {
  test::Random random(1);
  for (int k = 0; k < 50000; ++k) {
    const Vector3d a = random.inCube(1), b = random.inCube(1), p = random.inCube(2);
    Vector3d c = random.inCube(1);
    if (k % 5 == 1) c = 0.5 * (a + b) + 1e-3 * c;             // a sliver
    if (k % 5 == 2) c = a + 1e-4 * c;                         // a needle
    if (k % 5 == 3) c = a + random.between(-1, 2) * (b - a);  // degenerate, up to rounding
    if (k % 5 == 4) c = k % 2 ? a : Vector3d(0.5 * (a + b));  // degenerate
    const NearestPoint q = nearestOnTriangle(p, a, b, c);
    EXPECT_NEAR(q.distance, triangleDistance(p, a, b, c), k % 5 == 3 ? 1e-8 : 1e-11) << k;
    EXPECT_NEAR((p - q.point).norm(), q.distance, 1e-15);
    EXPECT_LT(triangleDistance(q.point, a, b, c), k % 5 == 3 ? 1e-8 : 1e-11) << "the nearest point must lie on the triangle";
  }
}

TEST(NearestOnTriangle, SmallTrianglesFarAwayKeepTheirDigits) {
  test::Random random(7);
  for (int k = 0; k < 20000; ++k) {
    const double size = std::pow(10, random.between(-7, -2));
    const Vector3d a = random.inCube(1), b = a + size * random.inCube(1), p = random.inCube(1);
    const Vector3d c = k % 2 ? Vector3d(a + size * random.inCube(1)) : Vector3d(0.5 * (a + b) + 1e-2 * size * random.inCube(1));
    EXPECT_NEAR(nearestOnTriangle(p, a, b, c).distance, triangleDistance(p, a, b, c), 1e-13) << k;
  }
}

TEST(NearestOnTriangle, NamesTheFeature) {
  const Vector3d a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  EXPECT_EQ(nearestOnTriangle({0.25, 0.25, 1}, a, b, c).feature, 0);
  EXPECT_EQ(nearestOnTriangle({1, 1, 1}, a, b, c).feature, 1);
  EXPECT_EQ(nearestOnTriangle({-1, 0.5, 1}, a, b, c).feature, 2);
  EXPECT_EQ(nearestOnTriangle({0.5, -1, 1}, a, b, c).feature, 3);
  EXPECT_EQ(nearestOnTriangle({-1, -1, 1}, a, b, c).feature, 4);
  EXPECT_EQ(nearestOnTriangle({3, -1, 1}, a, b, c).feature, 5);
  EXPECT_EQ(nearestOnTriangle({-1, 3, 1}, a, b, c).feature, 6);
}

TEST(DistanceField, NearestTriangleIsTheOneOfBruteForce) {
  test::Random random(2);
  TriangleMesh soup;
  for (std::uint32_t t = 0; t < 400; ++t) {
    const Vector3d a = random.inCube(1);
    for (int k = 0; k < 3; ++k) soup.positions.push_back(a + random.inCube(0.2));
    soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  // Duplicate triangles, so that ties occur: the lower index wins.
  soup.triangles.insert(soup.triangles.end(), soup.triangles.begin(), soup.triangles.begin() + 100);
  const DistanceField field(soup);
  for (int k = 0; k < 2000; ++k) {
    const Vector3d p = random.inCube(1.5);
    NearestPoint best;
    for (std::uint32_t t = 0; t < soup.triangles.size(); ++t) {
      NearestPoint q = nearestOnTriangle(p, soup.corner(t, 0), soup.corner(t, 1), soup.corner(t, 2));
      q.triangle = t;
      if (q.distance < best.distance) best = q;
    }
    const NearestPoint found = field.nearest(p);
    EXPECT_EQ(found.distance, best.distance);
    EXPECT_EQ(found.triangle, best.triangle);
    EXPECT_EQ(found.point, best.point);
    EXPECT_EQ(field.nearest(p, best.distance * (1 + 1e-9)).triangle, best.triangle);
    EXPECT_TRUE(std::isinf(field.nearest(p, best.distance).distance)) << "nothing is nearer than the nearest";
  }
}

TEST(DistanceField, SignedDistanceToABoxIsTheClosedForm) {
  const Vector3d low(-1, 2, 5), high(3, 2.5, 9);
  const DistanceField field(test::boxMesh(low, high));
  test::Random random(3);
  for (int k = 0; k < 5000; ++k) {
    const Vector3d p = random.inBox(low - Vector3d::Ones(), high + Vector3d::Ones());
    EXPECT_NEAR(field.signedDistance(p), test::boxDistance(low, high, p), 1e-14);
  }
}

TEST(DistanceField, SignIsTheOneOfTheWindingNumber) {
  const TriangleMesh torus = test::torusMesh(2, 0.7, 24, 11);
  const DistanceField field(torus);
  test::Random random(4);
  int inside = 0;
  for (int k = 0; k < 3000; ++k) {
    const Vector3d p = random.inBox({-3, -3, -1}, {3, 3, 1});
    const double distance = field.signedDistance(p);
    if (std::abs(distance) < 1e-9) continue;
    EXPECT_EQ(distance<0, windingNumber(torus, p)> 0.5) << p.transpose();
    inside += distance < 0;
  }
  EXPECT_GT(inside, 500);
}

// Nearest points on edges and corners, where face normals differ, on both sides.
TEST(DistanceField, SignHoldsNextToEdgesAndCorners) {
  const TriangleMesh torus = test::torusMesh(2, 0.7, 9, 5);
  const DistanceField field(torus);
  test::Random random(5);
  for (std::size_t t = 0; t < torus.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const double along = random.unit();
      for (const Vector3d& at : {torus.corner(t, k), Vector3d(along * torus.corner(t, k) + (1 - along) * torus.corner(t, (k + 1) % 3))}) {
        const Vector3d p = at + 1e-3 * random.direction();
        if (field.distance(p) < 1e-7) continue;
        EXPECT_EQ(field.signedDistance(p) < 0, windingNumber(torus, p) > 0.5);
      }
    }
}

TEST(DistanceField, CornersOfEqualPositionShareTheirNormals) {
  TriangleMesh box = test::boxMesh({0, 0, 0}, {1, 1, 1}), split;
  for (const Triangle& t : box.triangles)
    for (const std::uint32_t v : t) split.positions.push_back(box.positions[v]);
  for (std::uint32_t t = 0; t < 12; ++t) split.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  const DistanceField whole(box), apart(split);
  test::Random random(6);
  for (int k = 0; k < 1000; ++k) {
    const Vector3d p = random.inBox({-1, -1, -1}, {2, 2, 2});
    EXPECT_EQ(whole.signedDistance(p), apart.signedDistance(p));
  }
}

TEST(DistanceField, KnowsSizeAreaAndVolume) {
  // Far from the origin, where products of coordinates lose digits.
  const DistanceField field(test::boxMesh({1e6, 0, 0}, {1e6 + 2, 3, 4}));
  EXPECT_NEAR(field.volume(), 24, 1e-8);
  EXPECT_NEAR(field.area(), 52, 1e-8);
  EXPECT_NEAR(field.diagonal(), std::sqrt(29.0), 1e-9);
  EXPECT_EQ(field.triangleCount(), 12u);
  const TriangleMesh mesh = test::torusMesh(2, 0.5, 8, 6);
  const DistanceField torus(mesh);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) EXPECT_EQ(torus.corners(t)[static_cast<std::size_t>(k)], mesh.corner(t, k));
}

TEST(DistanceField, RefusesAMeshWithoutTriangles) { EXPECT_THROW(DistanceField{TriangleMesh{}}, std::invalid_argument); }

}  // namespace
}  // namespace spheretree::builder
