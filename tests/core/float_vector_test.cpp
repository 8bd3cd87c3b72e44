// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/float_vector.h"

#include <gtest/gtest.h>

namespace spheretree {
namespace {

TEST(FloatVector, TheLastTwoTermsAreAddedFirst) {
  const Eigen::Vector3f v(1, 1e8f, -1e8f), ones(1, 1, 1);
  EXPECT_EQ(dotOf(v, ones), 1) << "otherwise 1e8 would absorb the first term";
  EXPECT_EQ(dotOf({1e8f, -1e8f, 1}, ones), 0);
  // 2^24 + 1 is not a float, 2^24 + 2 is.
  EXPECT_EQ(squareOf({4096, 1, 1}), 16777218.0f);
  EXPECT_EQ(squareOf({1, 4096, 1}), 16777216.0f);
  EXPECT_EQ(lengthOf({2, 3, 6}), 7);
}

}  // namespace
}  // namespace spheretree
