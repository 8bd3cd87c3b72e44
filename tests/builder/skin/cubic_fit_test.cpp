// SPDX-License-Identifier: GPL-3.0-or-later
#include "skin/cubic_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "support/random.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

struct FitError {
  double normal = 0, height = 0;  // [rad]; from the sphere [mm]
};

/// Of a fit to 18 random points of a sphere of radius 5, within `reach` of one of its points; the normal that is given
/// is off by 0.3 rad.
FitError errorOnASphere(double reach, std::uint64_t seed) {
  test::Random random(seed);
  const Vector3d n = random.direction(), x = n.unitOrthogonal(), y = n.cross(x);
  const auto on_sphere = [&](double share) {
    const double angle = random.between(0, 6.28);
    return Vector3d(5 * (n + share / 5 * (std::cos(angle) * x + std::sin(angle) * y)).normalized());
  };
  std::vector<Vector3d> around;
  for (int i = 0; i < 18; ++i) around.push_back(on_sphere(reach * random.between(0.4, 1)));
  const CubicFit fit(5 * n, (n + 0.3 * x).normalized(), around);
  FitError worst;
  for (int i = 0; i < 20; ++i) {
    const CubicFit::Point p = fit.at(on_sphere(0.5 * reach * random.unit()));
    worst.normal = std::max(worst.normal, p.normal.cross(p.position.normalized()).norm());
    worst.height = std::max(worst.height, std::abs(p.position.norm() - 5));
  }
  return worst;
}

TEST(CubicFit, IsBetterTheNearerThePointsAre) {
  FitError coarse, fine;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const FitError one = errorOnASphere(1, seed), half = errorOnASphere(0.5, seed);
    coarse = {std::max(coarse.normal, one.normal), std::max(coarse.height, one.height)};
    fine = {std::max(fine.normal, half.normal), std::max(fine.height, half.height)};
  }
  EXPECT_LT(coarse.normal, 0.01);
  EXPECT_LT(coarse.height, 0.0015);
  EXPECT_LT(fine.normal, 0.35 * coarse.normal);
  EXPECT_LT(fine.height, 0.2 * coarse.height);
}

TEST(CubicFit, PassesThroughItsVertexAndIsExactOnAPlane) {
  test::Random random(3);
  const Vector3d n = random.direction(), x = n.unitOrthogonal(), y = n.cross(x), origin(4, 5, 6);
  std::vector<Vector3d> around;
  for (int i = 0; i < 9; ++i) around.push_back(origin + random.between(-1, 1) * x + random.between(-1, 1) * y);
  const CubicFit fit(origin, (n + 0.4 * y).normalized(), around);
  EXPECT_LT((fit.at(origin).position - origin).norm(), 1e-12);
  EXPECT_LT(fit.at(origin + 0.3 * x).normal.cross(n).norm(), 1e-9);
}

}  // namespace
}  // namespace spheretree::builder
