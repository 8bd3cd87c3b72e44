// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/rounding.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/random.h"

namespace spheretree {
namespace {

TEST(Rounding, UpIsTheLeastFloatThatIsNotBelow) {
  test::Random random(1);
  for (int i = 0; i < 100'000; ++i) {
    const double x = std::ldexp(random.between(-1, 1), static_cast<int>(random.below(80)) - 40);
    const float up = roundUp(x);
    ASSERT_GE(static_cast<double>(up), x);
    ASSERT_LT(static_cast<double>(std::nextafterf(up, -std::numeric_limits<float>::infinity())), x) << "no smaller float would do";
  }
  for (const float exact : {0.0f, 1.0f, -3.5f, std::numeric_limits<float>::max()}) EXPECT_EQ(roundUp(exact), exact);
  EXPECT_EQ(roundUp(1e300), std::numeric_limits<float>::infinity());
}

}  // namespace
}  // namespace spheretree
