// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/reduce_grid.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/regions.h"

namespace spheretree::builder {
namespace {

TEST(ReduceGrid, CoversWithFewBallsAndIsPure) { test::expectReduces(reduceGrid); }

// The octants of a cube: each ball is the smallest of three quarter faces, whose ends are two opposite corners of the
// octant.
TEST(ReduceGrid, FindsTheOctantsOfACube) {
  TriangleMesh cube = test::boxMesh({-1, -1, -1}, {1, 1, 1});
  const test::WholeRegion whole(cube, 3000);
  const std::vector<FittedBall> balls = reduceGrid(whole.region(8));
  EXPECT_EQ(balls.size(), 8u);
  EXPECT_LE(test::worstOverhang(balls), std::sqrt(0.75) - 0.5 + 0.02);
}
}  // namespace
}  // namespace spheretree::builder
