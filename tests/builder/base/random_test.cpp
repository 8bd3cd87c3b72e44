// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/random.h"

#include <gtest/gtest.h>

namespace spheretree::builder {
namespace {

TEST(RandomUnit, HoldsTheUpperBitsOfTheGenerator) {
  std::mt19937_64 random(5), same(5);
  double sum = 0;
  for (int i = 0; i < 10'000; ++i) {
    const double x = randomUnit(random);
    ASSERT_EQ(static_cast<std::uint64_t>(x * 0x1p53), same() >> 11);
    ASSERT_LT(x, 1);
    sum += x;
  }
  EXPECT_NEAR(sum / 10'000, 0.5, 0.01);
}

}  // namespace
}  // namespace spheretree::builder
