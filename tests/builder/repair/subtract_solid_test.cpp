// SPDX-License-Identifier: GPL-3.0-or-later
#include "repair/subtract_solid.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "geometry/distance_field.h"
#include "spheretree/builder/mesh_checks.h"
#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

TriangleMesh turned(TriangleMesh mesh, const Eigen::Quaterniond& turn, const Vector3d& shift) {
  for (Vector3d& p : mesh.positions) p = turn * p + shift;
  return mesh;
}

TEST(SubtractSolid, LeavesWhatIsInTheOneAndNotInTheOther) {
  test::Random random(3);
  for (int i = 0; i < 6; ++i) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(random.between(0, 3), random.direction()));
    const TriangleMesh from = test::boxMesh({-1, -1, -1}, {1, 1, 1});
    const TriangleMesh taken = i % 2 == 0 ? turned(test::sphereMesh(0.7, 3), turn, random.inCube(1.2))
                                          : turned(test::torusMesh(0.8, 0.2, 24, 12), turn, random.inCube(0.8));
    Progress progress;
    const std::optional<Difference> left = subtractSolid(from, taken, progress);
    ASSERT_TRUE(left.has_value());
    EXPECT_LT(left->moved, 1e-5);
    EXPECT_TRUE(checkMesh(left->mesh, 10, progress).clean());
    const DistanceField a(from), b(taken), c(left->mesh);
    for (int n = 0; n < 3000; ++n) {
      const Vector3d p = random.inCube(1.3);
      const double in_a = a.signedDistance(p), in_b = b.signedDistance(p);
      if (std::abs(in_a) < 1e-5 || std::abs(in_b) < 1e-5) continue;
      EXPECT_EQ(c.signedDistance(p) < 0, in_a < 0 && in_b > 0) << i;
    }
  }
}

TEST(SubtractSolid, KeepsTheTrianglesThatNothingTouches) {
  const TriangleMesh from = test::boxMesh({-1, -1, -1}, {1, 1, 1});
  Progress progress;
  const std::optional<Difference> far = subtractSolid(from, test::boxMesh({3, 3, 3}, {4, 4, 4}), progress);
  ASSERT_TRUE(far.has_value());
  EXPECT_EQ(far->mesh.triangles.size(), from.triangles.size());
  const std::optional<Difference> hollow = subtractSolid(from, test::boxMesh({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}), progress);
  ASSERT_TRUE(hollow.has_value());
  EXPECT_EQ(hollow->mesh.triangles.size(), 24u);
  EXPECT_NEAR(DistanceField(hollow->mesh).volume(), 7, 1e-12);
  const std::optional<Difference> nothing = subtractSolid(from, test::boxMesh({-2, -2, -2}, {2, 2, 2}), progress);
  ASSERT_TRUE(nothing.has_value());
  EXPECT_TRUE(nothing->mesh.triangles.empty());
}

}  // namespace
}  // namespace spheretree::builder
