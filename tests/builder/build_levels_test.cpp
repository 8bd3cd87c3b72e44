// SPDX-License-Identifier: GPL-3.0-or-later
#include "build_levels.h"

#include <gtest/gtest.h>

#include <algorithm>

#include <stdexcept>

#include "support/shapes.h"

namespace spheretree::builder {
namespace {

LevelBalls build(BuilderKind kind, const std::vector<BuilderKind>& combine = {}) {
  const TriangleMesh mesh = test::torusMesh(5, 2, 16, 8);
  const DistanceField field(mesh);
  BuildSettings settings;
  settings.builder = kind;
  settings.combine = combine;
  settings.quality = Quality::Quick;
  settings.levels = 3;
  settings.branching = 4;
  Progress progress;
  return LevelBuilder(mesh, field).build(settings, progress);
}

bool areEqual(const LevelBalls& a, const LevelBalls& b) {
  if (a.parents != b.parents || a.balls.size() != b.balls.size()) return false;
  for (std::size_t level = 0; level < a.balls.size(); ++level) {
    if (a.balls[level].size() != b.balls[level].size()) return false;
    for (std::size_t i = 0; i < a.balls[level].size(); ++i)
      if (a.balls[level][i].centre != b.balls[level][i].centre || a.balls[level][i].radius != b.balls[level][i].radius) return false;
  }
  return true;
}

TEST(BuildLevels, EveryBuilderFitsTheBudget) {
  for (int kind = 0; kind <= static_cast<int>(BuilderKind::Octree); ++kind) {
    SCOPED_TRACE(name(static_cast<BuilderKind>(kind)));
    const LevelBalls levels = build(static_cast<BuilderKind>(kind));
    ASSERT_EQ(levels.balls.size(), 3u);
    for (std::size_t level = 0, largest = 1; level < 3; ++level, largest *= 4) {
      EXPECT_GE(levels.balls[level].size(), 1u);
      EXPECT_LE(levels.balls[level].size(), largest);
      if (levels.parents.empty()) continue;
      ASSERT_EQ(levels.parents[level].size(), levels.balls[level].size());
      for (const std::uint32_t parent : levels.parents[level]) EXPECT_EQ(parent == kNone, level == 0);
    }
    EXPECT_EQ(levels.parents.empty(), static_cast<BuilderKind>(kind) == BuilderKind::Cover) << "a published method has its own parents";
  }
}

TEST(BuildLevels, ACombinationOfOneReducerEqualsItAndTheDefaultHasThree) {
  EXPECT_TRUE(areEqual(build(BuilderKind::Combined, {BuilderKind::Grid}), build(BuilderKind::Grid)));
  EXPECT_TRUE(
      areEqual(build(BuilderKind::Combined), build(BuilderKind::Combined, {BuilderKind::Expand, BuilderKind::Merge, BuilderKind::Burst})));
  EXPECT_FALSE(areEqual(build(BuilderKind::Merge), build(BuilderKind::Grid)));
}

TEST(BuildLevels, ASearchDistributesTheBallsOfAnyStart) {
  const TriangleMesh mesh = test::torusMesh(5, 1, 24, 10);
  const DistanceField field(mesh);
  const auto worst = [&](const LevelBalls& levels) {
    double overhang = 0;
    for (const Ball& b : levels.balls.back()) overhang = std::max(overhang, b.radius + field.signedDistance(b.centre));
    return overhang;
  };
  for (const BuilderKind kind : {BuilderKind::Merge, BuilderKind::Spawn, BuilderKind::Hubbard, BuilderKind::Octree}) {
    SCOPED_TRACE(name(kind));
    BuildSettings settings;
    settings.builder = kind;
    settings.quality = Quality::Quick;
    settings.levels = 3;
    Progress progress;
    const LevelBalls own = LevelBuilder(mesh, field).build(settings, progress);
    settings.search = true;
    const LevelBalls searched = LevelBuilder(mesh, field).build(settings, progress);
    EXPECT_TRUE(searched.parents.empty()) << "levels of a search are grouped at the end";
    EXPECT_EQ(searched.balls.back().size(), 64u) << "balls are added up to the budget";
    EXPECT_LT(worst(searched), 0.8 * worst(own));
  }
}

TEST(BuildLevels, OnlyMethodsThatBuildByRegionsCombine) {
  for (const BuilderKind kind : {BuilderKind::Cover, BuilderKind::Octree, BuilderKind::Combined})
    EXPECT_THROW(build(BuilderKind::Combined, {BuilderKind::Merge, kind}), std::invalid_argument) << name(kind);
}

}  // namespace
}  // namespace spheretree::builder
