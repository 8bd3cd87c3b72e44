// SPDX-License-Identifier: GPL-3.0-or-later
#include "cover/choose_balls.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "medial/shrinking_balls.h"
#include "support/dense_points.h"
#include "support/found_cover.h"
#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

const SearchSettings kQuickSearch{.moves = 200, .work = 5'000'000};

Cover coverBy(const TriangleMesh& mesh, std::span<const Ball> pool, std::size_t spheres, std::size_t samples = 1000,
              const SearchSettings& search = kQuickSearch) {
  Progress progress;
  SampleSettings sampling;
  sampling.count = samples;
  return test::foundCover(mesh, sampleSurface(mesh, sampling), pool, spheres, search, progress);
}

std::vector<Ball> touchingBalls(const TriangleMesh& mesh, std::size_t count) {
  SampleSettings sampling;
  sampling.count = count;
  return shrinkingBalls(sampleSurface(mesh, sampling), DistanceField(mesh));
}

// Smallest stand-off of any `choose` balls of the pool on dense points of the mesh, by trying every subset.
double bestSubset(const TriangleMesh& mesh, std::span<const Ball> pool, int choose) {
  const std::vector<Vector3d> points = test::densePoints(mesh, 60, 5);
  double best = std::numeric_limits<double>::infinity();
  for (unsigned mask = 0; mask < 1u << pool.size(); ++mask) {
    if (std::popcount(mask) != choose) continue;
    std::vector<Ball> chosen;
    for (std::size_t i = 0; i < pool.size(); ++i)
      if (mask >> i & 1) chosen.push_back(pool[i]);
    best = std::min(best, test::largestGap(points, chosen));
  }
  return best;
}

TEST(ChooseBalls, IsNoWorseThanTheBestSubsetOfThePool) {
  test::Random random(1);
  for (int trial = 0; trial < 6; ++trial) {
    const TriangleMesh mesh = trial % 2 ? test::boxMesh({0, 0, 0}, {6, 2, 1.5}) : test::torusMesh(3, 1.2, 16, 8);
    const DistanceField field(mesh);
    std::vector<Ball> pool;
    while (pool.size() < 12) {
      const Vector3d c = random.inBox(field.box().min(), field.box().max());
      const double clearance = -field.signedDistance(c);
      if (clearance > 0.3) pool.push_back({c, clearance});
    }
    const int choose = 2 + trial % 3 / 2;
    const Cover cover = coverBy(mesh, pool, static_cast<std::size_t>(choose));
    EXPECT_LE(cover.stand_off, bestSubset(mesh, pool, choose) * 1.001) << "trial " << trial;
  }
}

TEST(ChooseBalls, BallsStandOffAlikeAndCoverTheMesh) {
  const TriangleMesh mesh = test::torusMesh(5, 2, 24, 12);
  const DistanceField field(mesh);
  for (const std::size_t n : {1, 5, 40}) {
    const Cover cover = coverBy(mesh, touchingBalls(mesh, 500), n);
    ASSERT_EQ(cover.balls.size(), n);
    for (const Ball& b : cover.balls) {
      EXPECT_LT(field.signedDistance(b.centre), 0);
      EXPECT_NEAR(b.radius, test::bruteDistance(mesh, b.centre) + cover.stand_off, 1e-12);
    }
    EXPECT_LE(test::largestGap(test::densePoints(mesh, 60, 5), cover.balls), 0.02 * cover.stand_off);
  }
}

// N discs that cover the plane have a total area of at least 1.2092 times its area; the discs of balls of radius 1/2 +
// h about the middle plane of a slab of thickness 1 have the area pi (h + h^2). The rim needs slightly more.
TEST(ChooseBalls, SlabComesNearTheHexagonalCovering) {
  const double side = 16;
  const TriangleMesh slab = test::boxMesh({0, 0, 0}, {side, side, 1});
  const std::size_t n = 100;
  const double k = 1.2091995761561452 * side * side / (std::numbers::pi * static_cast<double>(n));
  const double formula = 0.5 * (std::sqrt(1 + 4 * k) - 1);
  const Cover cover = coverBy(slab, touchingBalls(slab, 2000), n, 4000);
  EXPECT_LT(cover.stand_off, 1.3 * formula);
  EXPECT_GT(cover.stand_off, 0.9 * formula);
}

TEST(ChooseBalls, MoreSpheresNeedLessStandOff) {
  const TriangleMesh mesh = test::torusMesh(5, 2, 24, 12);
  const std::vector<Ball> pool = touchingBalls(mesh, 500);
  double last = std::numeric_limits<double>::infinity();
  for (const std::size_t n : {1, 4, 16, 64}) {
    const double h = coverBy(mesh, pool, n).stand_off;
    EXPECT_LT(h, 0.8 * last) << n;
    last = h;
  }
}

TEST(ChooseBalls, SameSeedSameBalls) {
  const TriangleMesh mesh = test::torusMesh(5, 2, 24, 12);
  const std::vector<Ball> pool = touchingBalls(mesh, 300);
  const Cover one = coverBy(mesh, pool, 12), two = coverBy(mesh, pool, 12);
  EXPECT_EQ(one.stand_off, two.stand_off);
  ASSERT_EQ(one.balls.size(), two.balls.size());
  for (std::size_t i = 0; i < one.balls.size(); ++i) EXPECT_EQ(one.balls[i].centre, two.balls[i].centre);
}

TEST(ChooseBalls, RefusesNothingToWorkWith) {
  const TriangleMesh mesh = test::boxMesh({0, 0, 0}, {1, 1, 1});
  const DistanceField field(mesh);
  Progress progress;
  const std::vector<Ball> pool{{{0.5, 0.5, 0.5}, 0.5}};
  EXPECT_THROW(chooseBalls(mesh, field, {}, pool, 2, 1, progress), std::invalid_argument);
  EXPECT_THROW(chooseBalls(mesh, field, sampleSurface(mesh, {100, 0.5, 1}), {}, 2, 1, progress), std::invalid_argument);
}

TEST(ChooseBalls, StopsWhenCancelled) {
  const TriangleMesh mesh = test::boxMesh({0, 0, 0}, {1, 1, 1});
  Progress progress;
  progress.cancel();
  const std::vector<Ball> pool{{{0.5, 0.5, 0.5}, 0.5}};
  EXPECT_THROW(chooseBalls(mesh, DistanceField(mesh), sampleSurface(mesh, {100, 0.5, 1}), pool, 2, 1, progress), Cancelled);
}

}  // namespace
}  // namespace spheretree::builder
