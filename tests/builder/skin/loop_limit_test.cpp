// SPDX-License-Identifier: GPL-3.0-or-later
#include "skin/loop_limit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

// On a regular grid the limit is a box spline, which reproduces polynomials up to the third degree: here z, a
// quadratic. The border of the grid is fixed; 20 rings inside, nothing of that is left.
TEST(LoopLimit, ReproducesAQuadraticOnARegularGrid) {
  constexpr int kSide = 41, kMiddle = 20;
  const auto heightAt = [](double x, double y) { return 0.1 * x * x - 0.07 * x * y + 0.03 * y * y + 0.2 * x; };
  const auto name = [](int i, int j) { return static_cast<std::uint32_t>(i * kSide + j); };
  std::vector<Vector3d> positions;
  Rings rings(kSide * kSide);
  for (int i = 0; i < kSide; ++i)
    for (int j = 0; j < kSide; ++j) {
      const double x = i - kMiddle + 0.5 * (j - kMiddle), y = std::sqrt(0.75) * (j - kMiddle);
      positions.emplace_back(x, y, heightAt(x, y));
      if (i > 0 && j > 0 && i + 1 < kSide && j + 1 < kSide)
        rings[name(i, j)] = {name(i + 1, j), name(i, j + 1), name(i - 1, j + 1), name(i - 1, j), name(i, j - 1), name(i + 1, j - 1)};
    }
  const LoopLimit limit(positions, rings, std::vector<std::array<std::uint32_t, 2>>(positions.size()));
  const std::uint32_t here = name(kMiddle, kMiddle), next = name(kMiddle + 1, kMiddle);
  EXPECT_LT((limit.normal(here) - Vector3d(-0.2, 0, 1).normalized()).norm(), 1e-9);
  const LoopLimit::Middle middle = limit.middle(here, next);
  EXPECT_LT((middle.offset - Vector3d(0, 0, heightAt(0.5, 0) - 0.5 * heightAt(1, 0))).norm(), 1e-9);
  EXPECT_LT((middle.normal - Vector3d(-0.3, 0.035, 1).normalized()).norm(), 1e-9);
}

}  // namespace
}  // namespace spheretree::builder
