// SPDX-License-Identifier: GPL-3.0-or-later
#include "cut/convex_cell.h"

#include <gtest/gtest.h>

#include <vector>

#include "support/random.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

TEST(ConvexCell, HasTheVolumeOfWhatIsLeft) {
  ConvexCell cell;
  cell.reset(0.5);
  EXPECT_DOUBLE_EQ(cell.volume(), 1);
  cell.clip({{0, 0, 2}, -0.5});  // z <= 0.25
  EXPECT_DOUBLE_EQ(cell.volume(), 0.75);
  cell.clip({{-1, -1, -1}, -0.75});  // a corner of three edges 0.25 long stays
  cell.clip({{0, 0, 1}, 1});
  EXPECT_TRUE(cell.isEmpty());
  EXPECT_EQ(cell.volume(), 0);
  cell.reset(0.5);
  cell.clip({{1, 1, 1}, 1.25});  // x + y + z <= -1.25
  EXPECT_NEAR(cell.volume(), 0.25 * 0.25 * 0.25 / 6, 1e-15);
  cell.clip({{0, 0, 0}, 0});  // everywhere
  EXPECT_NEAR(cell.volume(), 0.25 * 0.25 * 0.25 / 6, 1e-15);
  cell.clip({{0, 0, 0}, 1});  // nowhere
  EXPECT_TRUE(cell.isEmpty());
}

/// Two parts of a cut are the whole; through corners and edges, too.
TEST(ConvexCell, PartsOfACutAddUp) {
  test::Random random(2);
  for (int i = 0; i < 2000; ++i) {
    ConvexCell cell;
    cell.reset(1);
    for (int k = 0; k < 6; ++k) {
      const bool is_special = random.below(3) == 0;
      const Vector3d n = is_special ? Vector3d(Vector3d(1, 1, 1) - Vector3d::Unit(static_cast<int>(random.below(3)))) : random.direction();
      const double offset = is_special ? 0 : random.between(-0.8, 0.8);
      ConvexCell other = cell;
      const double before = cell.volume();
      cell.clip({n, offset});
      other.clip({-n, -offset});
      ASSERT_NEAR(cell.volume() + other.volume(), before, 1e-12);
    }
  }
}

}  // namespace
}  // namespace spheretree::builder
