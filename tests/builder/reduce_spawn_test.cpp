// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/reduce_spawn.h"

#include <gtest/gtest.h>

#include "support/regions.h"

namespace spheretree::builder {
namespace {

TEST(ReduceSpawn, CoversWithFewBallsAndIsPure) { test::expectReduces(reduceSpawn, 0.25); }

TEST(ReduceSpawn, GivesUpBeyondTheLimit) {
  const test::WholeRegion whole(test::boxMesh({-1, -2, -3}, {1, 2, 3}), 600);
  Region region = whole.region(8);
  const double reached = test::worstOverhang(reduceSpawn(region));
  region.limit = 0.2 * reached;
  EXPECT_TRUE(reduceSpawn(region).empty());
}

TEST(ReduceSpawn, NeedsNoMedialAxis) {
  const test::WholeRegion whole(test::torusMesh(5, 1, 40, 16), 300);
  Region region = whole.region(8);
  const double with = test::worstOverhang(reduceSpawn(region));
  region.pool = {};
  EXPECT_EQ(test::worstOverhang(reduceSpawn(region)), with);
}
}  // namespace
}  // namespace spheretree::builder
