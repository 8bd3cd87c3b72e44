// SPDX-License-Identifier: GPL-3.0-or-later
#include "tissue/inner_sheet.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

TEST(InnerSheet, LiesAtTwiceTheShareOfTheDepthOfASphere) {
  const TriangleMesh mesh = test::sphereMesh(5, 4);
  const DistanceField field(mesh);
  for (const double share : {0.1, 0.3}) {
    const TriangleMesh sheet = innerSheet(mesh, field, share, 0.1, 100);
    ASSERT_EQ(sheet.triangles.size(), mesh.triangles.size());
    for (const Vector3d& p : sheet.positions) EXPECT_NEAR(p.norm(), 5 * (1 - 2 * share), 0.15) << share;
  }
}

TEST(InnerSheet, IsNoDeeperThanTheStandOffAllows) {
  const TriangleMesh mesh = test::boxMesh({-10, -10, -3}, {10, 10, 3});
  const DistanceField field(mesh);
  const TriangleMesh sheet = innerSheet(mesh, field, 0.5, 100, 2);
  double deepest = 0;
  for (const Vector3d& p : sheet.positions) {
    EXPECT_LE(field.signedDistance(p), 1e-9) << "within the solid";
    deepest = std::max(deepest, -field.signedDistance(p));
  }
  EXPECT_NEAR(deepest, 3, 1e-3) << "half of the plate: the medial axis";
}

TEST(InnerSheet, DividesLongSides) {
  const TriangleMesh mesh = test::boxMesh({0, 0, 0}, {8, 8, 8});
  const TriangleMesh sheet = innerSheet(mesh, DistanceField(mesh), 0.25, 100, 1);
  EXPECT_GT(sheet.triangles.size(), 8 * mesh.triangles.size());
}

}  // namespace
}  // namespace spheretree::builder
