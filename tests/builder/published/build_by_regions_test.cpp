// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/build_by_regions.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "certify/certify_cover.h"
#include "published/reduce_burst.h"
#include "published/reduce_expand.h"
#include "published/reduce_grid.h"
#include "published/reduce_hubbard.h"
#include "published/reduce_merge.h"
#include "published/reduce_spawn.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

struct Named {
  std::string name;
  std::vector<Method> methods;
};

std::vector<Named> allMethods() {
  const Method merge{reduceMerge, true}, burst{reduceBurst, true}, expand{reduceExpand, true}, spawn{reduceSpawn, false},
      grid{reduceGrid, false}, hubbard{reduceHubbard, true};
  return {{"merge", {merge}},
          {"burst", {burst}},
          {"expand", {expand}},
          {"spawn", {spawn}},
          {"grid", {grid}},
          {"hubbard", {hubbard}},
          {"combined", {expand, merge, burst}}};
}

PublishedSettings quick(int levels) {
  PublishedSettings settings;
  settings.levels = levels;
  settings.quality = Quality::Quick;
  return settings;
}

double worstOverhang(const std::vector<Ball>& balls, const DistanceField& field) {
  double worst = 0;
  for (const Ball& b : balls) worst = std::max(worst, b.radius + field.signedDistance(b.centre));
  return worst;
}

std::size_t countAll(const LevelBalls& tree) {
  std::size_t count = 0;
  for (const auto& level : tree.balls) count += level.size();
  return count;
}

void expectSound(const LevelBalls& tree, const TriangleMesh& mesh, const DistanceField& field, const PublishedSettings& settings) {
  ASSERT_TRUE(tree.parents.empty());
  ASSERT_LE(tree.balls.size(), static_cast<std::size_t>(settings.levels));
  ASSERT_EQ(tree.balls[0].size(), 1u);
  Progress progress;
  for (std::size_t level = 0; level < tree.balls.size(); ++level) {
    SCOPED_TRACE("level " + std::to_string(level));
    for (const Ball& b : tree.balls[level]) {
      EXPECT_TRUE(b.centre.allFinite());
      EXPECT_TRUE(std::isfinite(b.radius));
      EXPECT_GT(b.radius, 0);
    }
    if (level > 0) {
      EXPECT_LE(tree.balls[level].size(), tree.balls[level - 1].size() * static_cast<std::size_t>(settings.branching));
      EXPECT_GE(tree.balls[level].size(), tree.balls[level - 1].size());
    }
    const CertifiedCover cover = certifyCover(mesh, tree.balls[level], Vector3d::Zero(), 1e-3 * field.diagonal(), progress);
    EXPECT_LE(cover.largest_growth, std::max(0.3 * worstOverhang(tree.balls[level], field), 2e-3 * field.diagonal()))
        << "the levels cover up to small gaps";
  }
}

TEST(BuildByRegions, EveryMethodMakesASoundTree) {
  for (const TriangleMesh& mesh :
       {test::boxMesh({0, 0, 0}, {1, 1, 1}), test::boxMesh({0, 0, 0}, {1, 1, 0.01}), test::torusMesh(5, 1, 24, 10)}) {
    const DistanceField field(mesh);
    for (const Named& named : allMethods()) {
      SCOPED_TRACE(named.name + ", " + std::to_string(mesh.triangles.size()) + " triangles");
      const PublishedSettings settings = quick(3);
      Progress progress;
      const LevelBalls tree = buildByRegions(mesh, field, named.methods, settings, progress);
      expectSound(tree, mesh, field, settings);
      ASSERT_EQ(tree.balls.size(), 3u);
      // Deeper levels are finer.
      EXPECT_LT(worstOverhang(tree.balls[1], field), worstOverhang(tree.balls[0], field));
      EXPECT_LT(worstOverhang(tree.balls[2], field), 0.8 * worstOverhang(tree.balls[1], field));
    }
  }
}

TEST(BuildByRegions, SameBallsForAnyNumberOfThreads) {
  const TriangleMesh mesh = test::torusMesh(5, 1, 24, 10);
  const DistanceField field(mesh);
  for (const Named& named : allMethods()) {
    SCOPED_TRACE(named.name);
    std::vector<LevelBalls> trees;
    for (const std::size_t threads : {1, 2, 4}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      Progress progress;
      trees.push_back(buildByRegions(mesh, field, named.methods, quick(3), progress));
    }
    for (std::size_t t = 1; t < trees.size(); ++t) {
      ASSERT_EQ(trees[t].balls.size(), trees[0].balls.size());
      for (std::size_t level = 0; level < trees[0].balls.size(); ++level) {
        ASSERT_EQ(trees[t].balls[level].size(), trees[0].balls[level].size());
        for (std::size_t i = 0; i < trees[0].balls[level].size(); ++i) {
          EXPECT_EQ(trees[t].balls[level][i].centre, trees[0].balls[level][i].centre);
          EXPECT_EQ(trees[t].balls[level][i].radius, trees[0].balls[level][i].radius);
        }
      }
    }
  }
}

TEST(BuildByRegions, AnyBranching) {
  const TriangleMesh mesh = test::boxMesh({0, 0, 0}, {3, 2, 1});
  const DistanceField field(mesh);
  for (const int branching : {2, 3, 5}) {
    PublishedSettings settings = quick(4);
    settings.branching = branching;
    Progress progress;
    const std::vector<Method> methods{{reduceExpand, true}};
    expectSound(buildByRegions(mesh, field, methods, settings, progress), mesh, field, settings);
  }
}

TEST(BuildByRegions, ASphereNeedsOneBall) {
  const TriangleMesh mesh = test::sphereMesh(2, 4);
  const DistanceField field(mesh);
  PublishedSettings settings = quick(4);
  settings.tolerance_mm = 0.05;  // above the error of the facets
  Progress progress;
  const LevelBalls tree = buildByRegions(mesh, field, std::vector<Method>{{reduceMerge, true}}, settings, progress);
  EXPECT_EQ(tree.balls.size(), 1u);
}

TEST(BuildByRegions, ALooserToleranceTakesFewerBalls) {
  const TriangleMesh mesh = test::torusMesh(5, 1, 24, 10);
  const DistanceField field(mesh);
  std::size_t before = 0;
  for (const double tolerance : {0.0, 0.4, 0.8}) {
    PublishedSettings settings = quick(4);
    settings.tolerance_mm = tolerance;
    Progress progress;
    const LevelBalls tree = buildByRegions(mesh, field, std::vector<Method>{{reduceExpand, true}}, settings, progress);
    const std::size_t count = countAll(tree);
    if (before > 0) {
      EXPECT_LT(count, before) << "tolerance " << tolerance;
    }
    before = count;
    if (tolerance > 0) {
      EXPECT_LE(worstOverhang(tree.balls.back(), field), tolerance);
    }
  }
}

TEST(BuildByRegions, CombinedIsOnNoLevelWorseThanAMember) {
  const TriangleMesh mesh = test::torusMesh(5, 1, 24, 10);
  const DistanceField field(mesh);
  const Method merge{reduceMerge, true}, grid{reduceGrid, false};
  Progress progress;
  const LevelBalls both = buildByRegions(mesh, field, std::vector<Method>{merge, grid}, quick(4), progress);
  for (const Method& method : {merge, grid}) {
    const LevelBalls one = buildByRegions(mesh, field, std::vector<Method>{method}, quick(4), progress);
    for (std::size_t level = 0; level < one.balls.size(); ++level)
      EXPECT_LE(worstOverhang(both.balls[level], field), worstOverhang(one.balls[level], field)) << "level " << level;
  }
}

TEST(BuildByRegions, RefusesSettingsOutOfRange) {
  const TriangleMesh mesh = test::boxMesh({0, 0, 0}, {1, 1, 1});
  const DistanceField field(mesh);
  const std::vector<Method> methods{{reduceGrid, false}};
  Progress progress;
  for (auto spoil : std::vector<void (*)(PublishedSettings&)>{
           [](PublishedSettings& s) { s.levels = 1; }, [](PublishedSettings& s) { s.levels = 7; },
           [](PublishedSettings& s) { s.branching = 9; }, [](PublishedSettings& s) { s.branching = 1; },
           [](PublishedSettings& s) { s.tolerance_mm = -1; }}) {
    PublishedSettings settings;
    spoil(settings);
    EXPECT_THROW(buildByRegions(mesh, field, methods, settings, progress), std::invalid_argument);
  }
  EXPECT_THROW(buildByRegions(mesh, field, {}, {}, progress), std::invalid_argument);
}

TEST(BuildByRegions, CanBeCancelled) {
  const TriangleMesh mesh = test::torusMesh(5, 1, 24, 10);
  const DistanceField field(mesh);
  Progress progress;
  progress.cancel();
  EXPECT_THROW(buildByRegions(mesh, field, std::vector<Method>{{reduceMerge, true}}, {}, progress), Cancelled);
}

// A minimal reader for the external meshes: only lines of v and f.
TriangleMesh readObj(const std::filesystem::path& path) {
  TriangleMesh mesh;
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string key, word;
    words >> key;
    if (key == "v") {
      Vector3d p;
      words >> p.x() >> p.y() >> p.z();
      mesh.positions.push_back(p);
    } else if (key == "f") {
      std::vector<std::uint32_t> face;
      while (words >> word) face.push_back(static_cast<std::uint32_t>(std::stoul(word)) - 1);
      for (std::size_t i = 2; i < face.size(); ++i) mesh.triangles.push_back({face[0], face[i - 1], face[i]});
    }
  }
  return mesh;
}

struct Reference {
  const char *mesh, *builder;
  double worst;  // overhang of the leaves of the reference toolkit, in shares of the diagonal, with part of the surface uncovered
};

// At or below the worst leaf overhang of the reference toolkit with every triangle covered, which its leaves do not
// achieve: on the plate and the probe 7.3 and 3.5 per cent of the surface are open. All builders and meshes:
// tests/pipeline/toolkit_comparison.py
TEST(BuildByRegions, ReachesNoFartherOutThanTheReferenceToolkit) {
  const std::filesystem::path folder = std::filesystem::path(SPHERETREE_SHARED_DIR) / "meshes" / "toolkit";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "needs " << folder;
  const Reference references[] = {{"tooth", "merge", 0.0443}, {"tooth", "burst", 0.0478},  {"bunny-2000", "expand", 0.0264},
                                  {"cube", "merge", 0.0229},  {"plate", "expand", 0.0232}, {"probe", "expand", 0.00446},
                                  {"probe", "grid", 0.01237}};
  for (const Reference& reference : references) {
    SCOPED_TRACE(std::string(reference.mesh) + " " + reference.builder);
    const TriangleMesh mesh = readObj(folder / (std::string(reference.mesh) + ".obj"));
    const DistanceField field(mesh);
    const std::vector<Named> all = allMethods();
    const auto named = std::find_if(all.begin(), all.end(), [&](const Named& n) { return n.name == reference.builder; });
    ASSERT_NE(named, all.end());
    Progress progress;
    const LevelBalls tree = buildByRegions(mesh, field, named->methods, {}, progress);
    const CertifiedCover cover = certifyCover(mesh, tree.balls.back(), Vector3d::Zero(), 1e-4 * field.diagonal(), progress);
    double worst = 0;
    for (const Sphere& s : cover.spheres) worst = std::max(worst, s.radius + field.signedDistance(Vector3d(s.x, s.y, s.z)));
    EXPECT_LE(worst, reference.worst * field.diagonal());
  }
}

// Meshes on which other programs crash or leave most of the surface uncovered, and own shapes of the same kinds: thin,
// slender, with a hole.
TEST(BuildByRegions, MeshesThatBreakOthers) {
  const std::filesystem::path folder = std::filesystem::path(SPHERETREE_SHARED_DIR) / "meshes";
  std::vector<TriangleMesh> meshes = {test::quartered(test::quartered(test::boxMesh({0, 0, 0}, {40, 30, 0.5}))),
                                      test::quartered(test::boxMesh({0, 0, 0}, {1, 1, 40})), test::torusMesh(20, 3, 32, 12)};
  for (const char* file : {"toolkit/plate.obj", "bench/organic_spot.obj", "bench/cad_fandisk.obj"})
    if (std::filesystem::exists(folder / file)) meshes.push_back(readObj(folder / file));
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    SCOPED_TRACE("mesh " + std::to_string(m));
    const TriangleMesh& mesh = meshes[m];
    ASSERT_FALSE(mesh.triangles.empty());
    const DistanceField field(mesh);
    for (const Named& named : allMethods()) {
      if (named.name != "merge" && named.name != "expand") continue;
      SCOPED_TRACE(named.name);
      Progress progress;
      const PublishedSettings settings = quick(4);
      expectSound(buildByRegions(mesh, field, named.methods, settings, progress), mesh, field, settings);
    }
  }
}

}  // namespace
}  // namespace spheretree::builder
