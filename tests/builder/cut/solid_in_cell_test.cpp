// SPDX-License-Identifier: GPL-3.0-or-later
#include "cut/solid_in_cell.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

bool holds(const CellPart& part, const Vector3d& p) {
  if (part.is_empty) return false;
  for (int k = 0; k < part.count; ++k) {
    const HalfSpace& h = part.half_spaces[static_cast<std::size_t>(k)];
    if (h.normal.dot(p) + h.offset > 0) return false;
  }
  return true;
}

TEST(SolidInCell, LiesBetweenItsBounds) {
  test::Random random(4);
  for (const TriangleMesh& mesh : {test::sphereMesh(1, 2), test::boxMesh({-1, -1, -1}, {1, 1, 1}), test::torusMesh(1, 0.3, 24, 12)}) {
    const DistanceField solid(mesh);
    std::size_t thin = 0;
    for (int cell = 0; cell < 400; ++cell) {
      const Vector3d centre = random.inCube(1.4);
      const double half = random.between(0.01, 0.3);
      const SolidInCell found = boundSolid(solid, centre, half);
      thin += found.inside.inner.count > 0 && found.inside.outer.count > 0;
      for (int i = 0; i < 40; ++i) {
        const Vector3d p = random.inCube(half);
        const bool is_inside = solid.signedDistance(centre + p) < 0;
        if (holds(found.inside.inner, p)) {
          EXPECT_TRUE(is_inside);
        }
        if (is_inside) {
          EXPECT_TRUE(holds(found.inside.outer, p));
        }
        if (holds(found.outside.inner, p)) {
          EXPECT_FALSE(is_inside);
        }
        if (!is_inside) {
          EXPECT_TRUE(holds(found.outside.outer, p));
        }
      }
    }
    EXPECT_GT(thin, 20u);
  }
}

}  // namespace
}  // namespace spheretree::builder
