// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/winding_number.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "support/shapes.h"
#include "support/soup.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
using test::boxMesh;

TEST(WindingNumber, IsOneInsideAndNoneOutside) {
  const TriangleMesh torus = test::torusMesh(5, 2, 48, 24);
  const WindingNumber winding(torus);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> across(-8, 8);
  int inside = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vector3d p(across(random), across(random), 0.5 * across(random));
    const double off = std::hypot(std::hypot(p.x(), p.y()) - 5, p.z()) - 2;
    if (std::abs(off) < 0.1) continue;  // the mesh is not quite round
    inside += off < 0;
    EXPECT_NEAR(winding.at(p), off < 0 ? 1 : 0, 0.03) << p.transpose();
  }
  EXPECT_GT(inside, 500);
}

TEST(WindingNumber, OnAFaceLeftOutIsTheMeanOfBothSides) {
  const TriangleMesh box = boxMesh({0, 0, 0}, {1, 1, 1});
  for (std::uint32_t t = 0; t < 12; ++t) {
    const Vector3d middle = (box.corner(t, 0) + box.corner(t, 1) + box.corner(t, 2)) / 3;
    EXPECT_NEAR(WindingNumber(box).at(middle, std::vector{t}), 0.5, 1e-9);
  }
}

// The tree of clusters against the direct sum of solid angles (L'Huilier's theorem), for triangles that bound no solid.
TEST(WindingNumber, AgreesWithThePlainSum) {
  const TriangleMesh soup = test::randomTriangles(400, 0.3, 3);
  const WindingNumber winding(soup);
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> across(-2, 2);
  for (int i = 0; i < 300; ++i) {
    const Vector3d p(across(random), across(random), across(random));
    double sum = 0;
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
      const Vector3d a = (soup.corner(t, 0) - p).normalized(), b = (soup.corner(t, 1) - p).normalized(),
                     c = (soup.corner(t, 2) - p).normalized();
      const auto side = [](const Vector3d& u, const Vector3d& v) { return 2 * std::asin(std::min(1.0, (u - v).norm() / 2)); };
      const double x = side(b, c), y = side(c, a), z = side(a, b), s = (x + y + z) / 2;
      const double product = std::tan(s / 2) * std::tan((s - x) / 2) * std::tan((s - y) / 2) * std::tan((s - z) / 2);
      const double angle = 4 * std::atan(std::sqrt(std::max(0.0, product)));
      sum += a.dot(b.cross(c)) > 0 ? angle : -angle;
    }
    EXPECT_NEAR(winding.at(p), sum / (4 * std::numbers::pi), 0.02) << p.transpose();
  }
}

}  // namespace
}  // namespace spheretree::builder
