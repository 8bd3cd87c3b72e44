// SPDX-License-Identifier: GPL-3.0-or-later
#include "cover/gap_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "support/random.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

struct Case {
  std::vector<Vector3d> points;
  std::vector<Ball> balls;
};
Case randomCase(std::uint64_t seed, int points, int balls) {
  test::Random random(seed);
  Case c;
  for (int i = 0; i < points; ++i) c.points.push_back(random.inCube(0.5));
  for (int i = 0; i < balls; ++i) c.balls.push_back({random.inCube(0.5), 0.3 * random.unit()});
  return c;
}

TEST(GapTable, HoldsThePairsWithinTheLimitFromBothSides) {
  const Case c = randomCase(1, 80, 40);
  const SampleIndex samples(c.points);
  for (const float limit : {0.6f, 0.25f}) {
    const GapTable table(samples, c.balls, limit);
    std::size_t entries = 0, from_samples = 0;
    for (std::size_t b = 0; b < c.balls.size(); ++b) {
      const auto found = table.ofCandidate(b);
      for (const GapTable::Entry& e : found)
        EXPECT_FLOAT_EQ(e.gap, static_cast<float>((samples[e.id] - c.balls[b].centre).norm() - c.balls[b].radius));
      std::size_t brute = 0;
      for (std::size_t s = 0; s < samples.size(); ++s)
        brute += static_cast<float>((samples[s] - c.balls[b].centre).norm() - c.balls[b].radius) <= limit;
      EXPECT_EQ(found.size(), brute);
      entries += found.size();
    }
    for (std::size_t s = 0; s < samples.size(); ++s) from_samples += table.ofSample(s).size();
    EXPECT_GT(entries, 100u);
    EXPECT_EQ(entries, from_samples);
  }
}

TEST(GreedyCover, CoversEverySampleOrSaysThatItCannot) {
  int covered = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const Case c = randomCase(seed, 60, 25);
    const SampleIndex samples(c.points);
    const GapTable table(samples, c.balls, 0.6);
    const std::vector<std::uint32_t> chosen = greedyCover(table, 0.6f, 8);
    EXPECT_LE(chosen.size(), 8u);
    if (chosen.empty()) continue;
    ++covered;
    for (std::size_t s = 0; s < samples.size(); ++s)
      EXPECT_TRUE(std::ranges::any_of(
          chosen, [&](std::uint32_t b) { return (samples[s] - c.balls[b].centre).norm() - c.balls[b].radius <= 0.6 + 1e-6; }));
    EXPECT_TRUE(greedyCover(table, 0.6f, chosen.size() - 1).empty());
  }
  EXPECT_GE(covered, 10);
}

TEST(ThinToFit, BoundsTheTable) {
  Case c = randomCase(3, 6000, 12000);  // each ball reaches every sample: 72 million pairs
  const SampleIndex samples(c.points);
  const std::vector<Ball> all = c.balls;
  thinToFit(samples, 0.01, c.balls);
  EXPECT_LE(c.balls.size(), all.size());
  c.balls = all;
  thinToFit(samples, 10, c.balls);
  EXPECT_LE(c.balls.size(), 400u) << "400 entries a sample";
  EXPECT_GE(c.balls.size(), 190u);
  for (const Ball& b : c.balls) EXPECT_TRUE(std::ranges::any_of(all, [&](const Ball& a) { return a.centre == b.centre; }));
}

}  // namespace
}  // namespace spheretree::builder
