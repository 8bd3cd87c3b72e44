// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/sample_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "support/random.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

std::vector<std::uint32_t> found(const SampleIndex& index, const Vector3d& centre, double radius) {
  std::vector<std::uint32_t> slots;
  index.within(centre, radius, [&](std::uint32_t slot, double distance) {
    EXPECT_NEAR(distance, (index[slot] - centre).norm(), 1e-15);
    slots.push_back(slot);
  });
  std::sort(slots.begin(), slots.end());
  return slots;
}

std::vector<Vector3d> randomPoints(std::size_t count, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Vector3d> points;
  for (std::size_t i = 0; i < count; ++i) points.push_back(random.inBox({-1, -2, -3}, {1, 2, 3}));
  return points;
}

TEST(SampleIndex, HoldsEveryPointOnce) {
  std::vector<Vector3d> points = randomPoints(500, 1);
  SampleIndex index(points);
  for (const Vector3d& p : randomPoints(1000, 6)) {
    points.push_back(p);
    index.append(p);
  }
  ASSERT_EQ(index.size(), points.size());
  for (std::size_t slot = 500; slot < points.size(); ++slot) EXPECT_EQ(index[slot], points[slot]) << "appended points take the next slot";
  std::vector<Vector3d> held;
  for (std::size_t i = 0; i < index.size(); ++i) held.push_back(index[i]);
  const auto less = [](const Vector3d& a, const Vector3d& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  };
  std::sort(points.begin(), points.end(), less);
  std::sort(held.begin(), held.end(), less);
  EXPECT_EQ(points, held);
}

TEST(SampleIndex, WithinAgreesWithBruteForceAppendedPointsIncluded) {
  SampleIndex index(randomPoints(800, 2));
  const std::vector<Vector3d> more = randomPoints(900, 3);  // few enough for a linear search, then enough for trees of their own
  test::Random random(4);
  std::size_t hits = 0;
  for (const Vector3d& p : more) {
    index.append(p);
    const Vector3d centre = random.inBox({-2, -3, -4}, {2, 3, 4});
    const double radius = random.between(0, 2);
    std::vector<std::uint32_t> expected;
    for (std::uint32_t i = 0; i < index.size(); ++i)
      if ((index[i] - centre).squaredNorm() <= radius * radius) expected.push_back(i);
    hits += expected.size();
    EXPECT_EQ(found(index, centre, radius), expected);
  }
  EXPECT_GT(hits, 1000u);
}

TEST(SampleIndex, TouchingCounts) {
  const std::vector<Vector3d> points{{3, 4, 0}, {0, 5, 0}, {0, 0, 5.0000001}};
  EXPECT_EQ(found(SampleIndex(points), {0, 0, 0}, 5).size(), 2u);
  EXPECT_EQ(found(SampleIndex(points), {3, 4, 0}, 0).size(), 1u);
}

TEST(SampleIndex, FindsNothingForAnInvalidRadius) {
  const SampleIndex index(randomPoints(50, 5));
  EXPECT_TRUE(found(index, {0, 0, 0}, -1).empty());
  EXPECT_TRUE(found(index, {0, 0, 0}, std::numeric_limits<double>::quiet_NaN()).empty());
  EXPECT_EQ(found(index, {0, 0, 0}, std::numeric_limits<double>::infinity()).size(), 50u);
}

TEST(SampleIndex, StartsEmpty) {
  SampleIndex index(std::span<const Vector3d>{});
  EXPECT_TRUE(found(index, {0, 0, 0}, 10).empty());
  index.append({1, 0, 0});
  EXPECT_EQ(found(index, {0, 0, 0}, 10), std::vector<std::uint32_t>{0});
}

}  // namespace
}  // namespace spheretree::builder
