// SPDX-License-Identifier: Apache-2.0
#include "quantile.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace spheretree::tool {
namespace {

TEST(Quantile, IsAValueOfTheList) {
  const std::vector<double> values{4, 1, 3, 2};
  EXPECT_EQ(quantile(values, 0), 1);
  EXPECT_EQ(quantile(values, 0.25), 2);
  EXPECT_EQ(quantile(values, 0.5), 3) << "the upper of the two values in the middle";
  EXPECT_EQ(quantile(values, 0.99), 4);
  EXPECT_EQ(quantile(values, 1), 4);
}

TEST(Quantile, CountsHundredthsFromBelow) {
  std::vector<float> values;
  for (int i = 0; i < 1000; ++i) values.push_back(static_cast<float>((i * 7) % 1000));
  EXPECT_EQ(quantile(values, 0.99), 990);
  EXPECT_EQ(quantile(values, 0.5), 500);
}

TEST(Quantile, OfNothingIsZero) { EXPECT_EQ(quantile(std::vector<std::uint32_t>(), 0.5), 0u); }

}  // namespace
}  // namespace spheretree::tool
