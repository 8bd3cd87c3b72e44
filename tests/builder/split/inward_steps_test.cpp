// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/inward_steps.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "support/field_surface.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

bool isInSquare(const Vector3d& p) { return p.head<2>().cwiseAbs().maxCoeff() < 2; }

TEST(InwardSteps, GoStraightDownFromAFlatSurface) {
  ScanSurface s = test::fieldOf(4, 0.5, [](double, double) { return 1.0; });
  test::addRegion(s, isInSquare);
  const auto steps = findInwardSteps(s.mesh, RegionBorders(s), Vector3d::UnitZ());
  EXPECT_EQ(steps.size(), 32u);  // the border is 16 mm long
  for (const InwardStep& step : steps) {
    EXPECT_NEAR(step.length, 0.25, 1e-12);
    EXPECT_NEAR((step.direction + Vector3d::UnitZ()).norm(), 0, 1e-12);
  }
}

TEST(InwardSteps, PointBelowEveryTriangleAtTheirVertex) {
  for (const double slope : {-3.0, -0.5, 0.5, 3.0}) {  // a ridge or a groove, which the border crosses
    ScanSurface s = test::fieldOf(4, 0.5, [&](double x, double) { return slope * std::abs(x); });
    test::addRegion(s, isInSquare);
    for (const InwardStep& step : findInwardSteps(s.mesh, RegionBorders(s), Vector3d::UnitZ())) {
      EXPECT_NEAR(step.direction.norm(), 1, 1e-12);
      for (std::size_t t = 0; t < s.mesh.triangles.size(); ++t) {
        if (std::ranges::find(s.mesh.triangles[t], step.vertex) == s.mesh.triangles[t].end()) continue;
        const Vector3d a = s.mesh.corner(t, 1) - s.mesh.corner(t, 0), b = s.mesh.corner(t, 2) - s.mesh.corner(t, 0);
        EXPECT_LT(step.direction.dot(a.cross(b).normalized()), -0.1) << "slope " << slope << ", vertex " << step.vertex;
      }
    }
  }
}

}  // namespace
}  // namespace spheretree::builder
