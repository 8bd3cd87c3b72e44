// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/reduce_spawn.h"

#include <gtest/gtest.h>

#include "support/regions.h"

namespace spheretree::builder {
namespace {

TEST(ReduceSpawn, CoversWithFewBallsAndIsPure) { test::expectReduces(reduceSpawn, 0.25); }

TEST(ReduceSpawn, NeedsNoMedialAxis) {
  const test::WholeRegion whole(test::torusMesh(5, 1, 40, 16), 300);
  Region region = whole.region(8);
  const double with = test::worstOverhang(reduceSpawn(region));
  region.pool = {};
  EXPECT_EQ(test::worstOverhang(reduceSpawn(region)), with);
}
}  // namespace
}  // namespace spheretree::builder
