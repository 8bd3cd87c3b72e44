// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/batch/error_curve.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

namespace spheretree::pipeline {
namespace {

ErrorCurve powerLaw(double factor, double power) {
  ErrorCurve curve;
  for (const double n : {8.0, 64.0, 512.0}) curve.add(n, factor * std::pow(n, -power));
  return curve;
}

TEST(ErrorCurve, IsAPowerBetweenAndBeyondItsPoints) {
  const ErrorCurve curve = powerLaw(20, 0.8);
  for (const double n : {1.0, 5.0, 8.0, 30.0, 64.0, 300.0, 512.0, 4000.0}) EXPECT_NEAR(curve.errorAt(n), 20 * std::pow(n, -0.8), 1e-9);
}

TEST(ErrorCurve, FallsWhateverWasMeasured) {
  ErrorCurve curve;
  for (const auto& [leaves, error] : {std::pair{64.0, 1.0}, {100.0, 1.3}, {50.0, 0.9}, {200.0, 0.2}, {201.0, 0.4}, {1.0, 7.0}})
    curve.add(leaves, error);
  double above = std::numeric_limits<double>::infinity();
  for (double n = 1; n < 5000; n *= 1.1) {
    EXPECT_LT(curve.errorAt(n), above);
    above = curve.errorAt(n);
  }
  EXPECT_NEAR(curve.errorAt(50), 0.9, 1e-12);   // not 64: it has more leaves and a larger error
  EXPECT_NEAR(curve.errorAt(201), 0.4, 1e-12);  // the last of two equal ones
}

TEST(ErrorCurve, MovesAlongWithAPointOfAnotherQuality) {
  ErrorCurve curve = powerLaw(20, 0.8);
  curve.moveTo(64, 0.5 * curve.errorAt(64));
  for (const double n : {8.0, 64.0, 512.0, 1000.0}) EXPECT_NEAR(curve.errorAt(n), 10 * std::pow(n, -0.8), 1e-9);
}

TEST(ShareLeaves, IsTheBestOfAllShares) {
  const std::vector<ErrorCurve> curves{powerLaw(10, 1), powerLaw(2, 0.7), powerLaw(30, 1.4)};
  const std::vector<std::size_t> largest{60, 60, 12};  // the third has fewer than it could use
  for (const std::size_t total : {3u, 10u, 25u, 60u}) {
    double smallest = std::numeric_limits<double>::infinity();
    for (std::size_t a = 1; a <= largest[0]; ++a)
      for (std::size_t b = 1; b <= largest[1] && a + b < total; ++b) {
        const std::size_t c = std::min(largest[2], total - a - b);
        smallest = std::min(smallest, std::max({curves[0].errorAt(double(a)), curves[1].errorAt(double(b)), curves[2].errorAt(double(c))}));
      }
    const LeafShares shares = shareLeaves(curves, largest, total);
    EXPECT_LE(std::accumulate(shares.leaves.begin(), shares.leaves.end(), std::size_t{0}), total);
    double worst = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_GE(shares.leaves[i], 1u);
      EXPECT_LE(shares.leaves[i], largest[i]);
      worst = std::max(worst, curves[i].errorAt(static_cast<double>(shares.leaves[i])));
    }
    EXPECT_NEAR(worst, smallest, 1e-9);
  }
}

TEST(ShareLeaves, AFullTreeDoesNotStopTheOthers) {
  const std::vector<ErrorCurve> curves{powerLaw(10, 1), powerLaw(1000, 1)};
  const LeafShares shares = shareLeaves(curves, std::vector<std::size_t>{500, 4}, 104);
  EXPECT_EQ(shares.leaves[0], 100u);
  EXPECT_EQ(shares.leaves[1], 4u);
  EXPECT_EQ(shareLeaves(curves, std::vector<std::size_t>{5, 4}, 104).leaves, (std::vector<std::size_t>{5, 4}));
}

}  // namespace
}  // namespace spheretree::pipeline
