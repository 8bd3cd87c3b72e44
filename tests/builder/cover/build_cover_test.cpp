// SPDX-License-Identifier: GPL-3.0-or-later
#include "cover/build_cover.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "support/dense_points.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

BuildSettings quick(int levels, int branching) {
  BuildSettings settings;
  settings.quality = Quality::Quick;
  settings.levels = levels;
  settings.branching = branching;
  return settings;
}

LevelBalls build(const TriangleMesh& mesh, const BuildSettings& settings) {
  Progress progress;
  const DistanceField field(mesh);
  return CoverBuilder(mesh, field).build(settings, progress);
}

// The common stand-off of all balls of a level.
double standOff(const TriangleMesh& mesh, const std::vector<Ball>& balls) {
  double smallest = 1e9, largest = 0;
  for (const Ball& b : balls) {
    const double h = b.radius - test::bruteDistance(mesh, b.centre);
    smallest = std::min(smallest, h);
    largest = std::max(largest, h);
  }
  EXPECT_NEAR(smallest, largest, 1e-12 * largest + 1e-13);
  return largest;
}

// A sheet whose thickness is 1e-5 of its width: its medial balls are smaller than any spacing of samples, and centres
// may also lie outside.
TEST(BuildCover, ASheetIsCoveredAboutAsWellAsDiscsCoverARectangle) {
  const double width = 10, thickness = 1e-4;
  const LevelBalls levels = build(test::boxMesh({0, 0, 0}, {width, width, thickness}), quick(3, 8));
  const double hexagonal = std::sqrt(2 / (3 * std::sqrt(3.0)) * width * width / 64);  // radius of 64 discs in the densest grid
  for (const Ball& b : levels.balls[2]) EXPECT_LT(b.radius, 1.6 * hexagonal);
}

// The stand-off of a ball over a polyhedron around it is the depth of the faces, which more balls hardly reduce.
TEST(BuildCover, OfARoundObjectNoLevelIsWorseThanTheOneAbove) {
  const TriangleMesh mesh = test::sphereMesh(10, 4);
  const LevelBalls levels = build(mesh, quick(4, 8));
  double above = 1e9;
  for (const std::vector<Ball>& balls : levels.balls) {
    const double h = standOff(mesh, balls);
    EXPECT_LE(h, above * (1 + 1e-12));
    above = h;
  }
}

TEST(BuildCover, LevelsFillTheBudgetStandOffAlikeAndCover) {
  const TriangleMesh mesh = test::torusMesh(5, 2, 24, 12);
  const LevelBalls levels = build(mesh, quick(4, 4));
  EXPECT_TRUE(levels.parents.empty());
  ASSERT_EQ(levels.balls.size(), 4u);
  const std::vector<Eigen::Vector3d> points = test::densePoints(mesh, 60, 1);
  double above = 1e9;
  for (std::size_t level = 0, largest = 1; level < 4; ++level, largest *= 4) {
    EXPECT_EQ(levels.balls[level].size(), largest);
    const double h = standOff(mesh, levels.balls[level]);
    EXPECT_LT(h, above);
    EXPECT_LE(test::largestGap(points, levels.balls[level]), 0.08 * h) << "twice the gap that `quick` leaves to the certificate";
    above = h;
  }
}

TEST(BuildCover, ToleranceGivesFewSpheresThatKeepIt) {
  const TriangleMesh mesh = test::torusMesh(5, 2, 24, 12);
  BuildSettings settings = quick(4, 4);
  const double whole = standOff(mesh, build(mesh, settings).balls.back());
  settings.tolerance_mm = 2 * whole;
  const LevelBalls small = build(mesh, settings);
  EXPECT_LE(standOff(mesh, small.balls.back()), settings.tolerance_mm);
  EXPECT_LT(small.balls.back().size(), 50u) << "the stand-off falls about as 1/n: half of 64, and some";
  for (std::size_t level = 1; level < small.balls.size(); ++level) EXPECT_LE(small.balls[level - 1].size(), small.balls[level].size());
  settings.tolerance_mm = 0.1 * whole;
  EXPECT_EQ(build(mesh, settings).balls.back().size(), 64u) << "out of reach: the whole budget";
}

// The ball with the smallest stand-off of a polyhedron around a sphere has its centre in the middle, however large the
// tolerance.
// `best` runs several searches at the same time.
TEST(BuildCover, AtBestTheLeavesForAToleranceAreTheSameForAnyNumberOfThreads) {
  const TriangleMesh mesh = test::torusMesh(5, 1, 24, 10);
  BuildSettings settings = quick(4, 8);
  settings.quality = Quality::Best;
  std::vector<LevelBalls> found;
  for (const std::size_t threads : {1u, 4u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const DistanceField field(mesh);
    CoverBuilder builder(mesh, field);
    Progress progress;
    for (const double tolerance : {0.5, 0.45}) {  // the second one continues from the first one
      settings.tolerance_mm = tolerance;
      found.push_back(builder.build(settings, progress));
      EXPECT_LE(standOff(mesh, found.back().balls.back()), tolerance);
    }
    for (std::size_t i = 0; i < 2; ++i) {
      const std::vector<Ball>&first = found[i].balls.back(), &other = found[found.size() - 2 + i].balls.back();
      ASSERT_EQ(first.size(), other.size());
      for (std::size_t b = 0; b < first.size(); ++b) {
        EXPECT_EQ(first[b].centre, other[b].centre);
        EXPECT_EQ(first[b].radius, other[b].radius);
      }
    }
  }
}

TEST(BuildCover, AToleranceThatOneBallKeepsGivesTheBallOfSmallestStandOff) {
  const TriangleMesh mesh = test::sphereMesh(10, 3);
  const double smallest = 10 - test::bruteDistance(mesh, {0, 0, 0});
  for (const double tolerance : {1.5 * smallest, 4 * smallest, 20 * smallest}) {
    BuildSettings settings = quick(3, 8);
    settings.tolerance_mm = tolerance;
    const LevelBalls levels = build(mesh, settings);
    ASSERT_EQ(levels.balls.back().size(), 1u) << tolerance;
    EXPECT_LE(standOff(mesh, levels.balls.back()), 1.2 * smallest) << tolerance;
  }
}

TEST(BuildCover, ASeedIsPartOfTheResult) {
  const TriangleMesh mesh = test::torusMesh(5, 2, 16, 8);
  BuildSettings settings = quick(2, 8);
  const LevelBalls one = build(mesh, settings), again = build(mesh, settings);
  settings.seed = 2;
  const LevelBalls other = build(mesh, settings);
  EXPECT_EQ(one.balls[1][0].centre, again.balls[1][0].centre);
  EXPECT_NE(one.balls[1][0].centre, other.balls[1][0].centre);
}

TEST(BuildCover, TellsItsStagesAndStopsInEach) {
  struct Stages : Progress {
    std::vector<std::string> names;
    std::string stop_at;
    void stage(std::string_view name) override {
      names.emplace_back(name);
      if (name == stop_at) cancel();
    }
  };
  const TriangleMesh mesh = test::torusMesh(5, 2, 16, 8);
  const DistanceField field(mesh);
  Stages all;
  CoverBuilder(mesh, field).build(quick(2, 4), all);
  EXPECT_EQ(all.names, (std::vector<std::string>{"cover"}));
  for (const std::string& name : all.names) {
    Stages stopped;
    stopped.stop_at = name;
    EXPECT_THROW(CoverBuilder(mesh, field).build(quick(2, 4), stopped), Cancelled) << name;
  }
}

TEST(BuildCover, KeepsToANumberOfLeavesAndUsesIt) {
  const TriangleMesh mesh = test::torusMesh(5, 2, 24, 12);
  double above = 1e9;
  for (const int leaves : {1, 7, 8, 50, 200}) {
    BuildSettings settings = quick(4, 8);
    settings.max_leaves = leaves;
    const LevelBalls levels = build(mesh, settings);
    ASSERT_EQ(levels.balls.back().size(), static_cast<std::size_t>(leaves));
    for (std::size_t level = 1; level < levels.balls.size(); ++level)
      EXPECT_LE(levels.balls[level].size(), 8 * levels.balls[level - 1].size());
    const double h = standOff(mesh, levels.balls.back());
    EXPECT_LT(h, above);
    above = h;
  }
  BuildSettings more = quick(3, 8);  // more than the levels allow
  more.max_leaves = 100;
  EXPECT_EQ(build(mesh, more).balls.back().size(), 64u);
  more.tolerance_mm = 1e-6;  // out of reach: all leaves are used, and no more
  more.max_leaves = 20;
  EXPECT_EQ(build(mesh, more).balls.back().size(), 20u);
}

}  // namespace
}  // namespace spheretree::builder
