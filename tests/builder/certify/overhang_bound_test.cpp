// SPDX-License-Identifier: GPL-3.0-or-later
#include "certify/overhang_bound.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

// A box, whose distance is known in closed form, near the origin and far from it.
TEST(OverhangBound, NoPointOfTheSphereIsFartherOutside) {
  for (const double far : {0.0, 1e6}) {
    const Vector3d low(far, -1, -2), high = low + Vector3d(3, 2, 4), origin(far, 0, 0);
    const DistanceField field(test::boxMesh(low, high));
    test::Random random(7);
    for (int i = 0; i < 60; ++i) {
      const Vector3d c = random.inCube(3);
      const Sphere sphere{static_cast<float>(c.x()), static_cast<float>(c.y()), static_cast<float>(c.z()),
                          static_cast<float>(random.between(0.1, 2))};
      const double bound = overhangBound(field, origin, sphere);
      const Vector3d centre = Vector3d(sphere.x, sphere.y, sphere.z) + origin;
      for (int k = 0; k < 500; ++k) EXPECT_LE(test::boxDistance(low, high, centre + sphere.radius * random.direction()), bound);
      EXPECT_NEAR(bound, sphere.radius + test::boxDistance(low, high, centre), 1e-9 * (1 + far))
          << "and it is attained for a centre inside";
    }
  }
}

}  // namespace
}  // namespace spheretree::builder
