// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "pipeline/batch/batch_result.h"
#include "pipeline/comparison/comparison_json.h"
#include "spheretree/formats/errors.h"
#include "support/scratch_folder.h"

namespace spheretree::pipeline {
namespace {

using Json = nlohmann::ordered_json;

builder::LevelEvaluation levelAt(int level, double size) {
  builder::LevelEvaluation out;
  out.level = level;
  out.spheres = static_cast<std::size_t>(level) + 3;
  out.overhang.max = 0.1 * size;
  out.overhang.bound = 0.1 * size + 1e-9;
  out.overhang.p99 = size / 3;
  out.overhang.mean = size / 7;
  out.overhang.worst_point = {size, -size, 1e-12};
  out.coverage.uncovered_fraction = 0.25;
  out.coverage.max_gap = size / 11;
  out.coverage.max_gap_bound = size / 10;
  out.coverage.worst_point = {0, size, 0.1};
  out.excess_volume_fraction = 1 / 3.0;
  out.missing_volume_fraction = 1e-300;
  return out;
}

ObjectResult builtObject(const std::string& name) {
  ObjectResult object;
  object.name = name;
  object.status = ItemStatus::Built;
  object.seconds = 0.125;
  object.saved = 7;
  object.bytes = 12345;
  object.tree = name + ".stree";
  TreeFigures& f = object.figures;
  f.triangles = 100;
  f.leaves = 8;
  f.nodes = 9;
  f.diagonal_mm = 17.3;
  f.tolerance_mm = 0.1;
  f.tolerance_met = false;
  f.certified = true;
  f.input_triangles = 14;
  f.repair = {{"fill holes", "one step", 2, 0, 0.25}, {"drop buried", "another \"step\"", 1, 2, 0}};
  f.notes = {"a note"};
  f.levels = {{0, 1, std::nullopt, std::nullopt}, {1, 4, 0.2 / 3, levelAt(1, 2.0 / 3)}};
  f.levels[1].overhang_bound_mm = f.levels[1].measured->overhang.bound;
  f.ratio = ToleranceRatio{1.5, 0.15};
  f.min_tolerance_mm = 0.05;
  f.work = std::vector<WorkFigures>{{"spot", 0.3, 20, 0.29}};
  return object;
}

BatchResult fullResult() {
  BatchResult result;
  result.generator = "spheretree test";
  result.scene = "some/scene.json";
  result.seconds = 3.5;
  result.objects = {builtObject("tool"), builtObject("thing")};
  result.objects[0].is_tool = true;
  result.objects.emplace_back();
  result.objects[2].name = "gone";
  result.objects[2].status = ItemStatus::Failed;
  result.objects[2].error = "gone.obj: cannot be read";
  BudgetResult budget;
  budget.budget = {20.5, true};
  budget.spent = 20.1;
  budget.met = true;
  budget.worst_ratio = 1.25;
  budget.common_ratio = 1.1;
  budget.has_recorded_paths = true;
  budget.rounds = {{false, 12, 1.4, 19.0}, {true, 13, std::nullopt, std::nullopt}};
  result.budget = budget;
  SpeedRow row;
  row.leaves_each = 8;
  row.leaves = 24;
  row.overhang_bound_mm = 1.5;
  row.memory_bytes = 4096;
  row.cost = StepCost{.steps = 5, .pairs_median = 3, .pairs_p99 = 9, .model_us_p99 = 2.5, .time_us_median = 1.5, .time_us_p99 = 4.5};
  SpeedRow chosen;
  chosen.object = "thing";
  chosen.chosen = true;
  result.speed = {row, chosen};
  return result;
}

Comparison fullComparison() {
  Comparison out;
  out.generator = "spheretree test";
  out.processor = "a processor";
  out.threads = 2;
  out.levels = 4;
  out.branching = 8;
  out.seed = 18446744073709551615u;
  out.meshes = {{"tooth", "/a/tooth.obj", 10, 100, 12.5, 30.25, 7.125, 512, {0.1, 0.09, false}}};
  pipeline::Run run{.mesh = "tooth",
                    .method = {{builder::BuilderKind::Merge, true}, builder::Quality::Best},
                    .error = {},
                    .tree = "trees/t.stree",
                    .seconds = 1.5,
                    .processor_seconds = 2.5,
                    .nodes = 585,
                    .levels = {levelAt(0, 3), levelAt(1, 1)},
                    .hierarchy = {512, 0, 3}};
  pipeline::Run failed;
  failed.mesh = "tooth";
  failed.error = "no tree";
  out.runs = {run, failed};
  out.sensitivity = {{"tooth", {}, "", {{"rotation", 24, 0.01, false}}}, {"tooth", {}, "no tree", {}}};
  out.means = geometricMeans(out);
  return out;
}

std::filesystem::path written(const std::string& text) {
  static const test::ScratchFolder kFolder;  // of this process alone: tests run side by side
  const std::filesystem::path path = kFolder.path() / "written.json";
  std::ofstream(path) << text;
  return path;
}

/// Every key of every object is removed once: the reader accepts its absence or refuses the file, and throws nothing
/// else.
template <class Read>
void removeEachKey(Json& whole, Json& at, Read&& read, std::size_t& refused) {
  if (at.is_object()) {
    std::vector<std::string> keys;
    for (const auto& item : at.items()) keys.push_back(item.key());
    for (const std::string& key : keys) {
      const Json saved = at;
      at.erase(key);
      const std::filesystem::path path = written(whole.dump());
      try {
        (void)read(path);
      } catch (const formats::FormatError&) {
        ++refused;
      }
      at = saved;
      removeEachKey(whole, at.at(key), read, refused);
    }
  } else if (at.is_array()) {
    for (Json& item : at) removeEachKey(whole, item, read, refused);
  }
}

TEST(BatchResult, ComesBackFromItsJson) {
  const Json json = toJson(fullResult());
  const BatchResult back = readBatchResult(written(json.dump()));
  EXPECT_EQ(toJson(back), json);
  ASSERT_EQ(back.objects.size(), 3u);
  EXPECT_EQ(back.objects[1].figures.levels[1].measured->coverage.worst_point, Eigen::Vector3d(0, 2.0 / 3, 0.1));
  EXPECT_FALSE(back.objects[1].figures.levels[0].measured.has_value());
}

TEST(BatchResult, TotalsCountTreesAndFailures) {
  const BatchTotals totals = totalsOf(fullResult());
  EXPECT_EQ(totals.built, 2u);
  EXPECT_EQ(totals.failed, 1u);
  EXPECT_EQ(totals.leaves, 16u);
  EXPECT_EQ(totals.bytes, 2u * 12345);
  EXPECT_EQ(totals.overhang_bound_mm, *builtObject("x").figures.levels[1].overhang_bound_mm);
}

TEST(BatchResult, RefusesFilesOfOtherKinds) {
  EXPECT_THROW(readBatchResult("/no/such/file"), formats::FileError);
  EXPECT_THROW(readBatchResult(written("[1, 2")), formats::FormatError);
  EXPECT_THROW(readBatchResult(written("{\"schema\": \"spheretree.batch/2\"}")), formats::FormatError);
  Json json = toJson(fullResult());
  std::size_t refused = 0;
  removeEachKey(json, json, readBatchResult, refused);
  EXPECT_GT(refused, 50u);
}

TEST(Comparison, ComesBackFromItsJson) {
  const Json json = toJson(fullComparison());
  EXPECT_EQ(toJson(readComparison(written(json.dump()))), json);
}

TEST(Comparison, RefusesFilesOfOtherKinds) {
  Json json = toJson(fullComparison());
  std::size_t refused = 0;
  removeEachKey(json, json, readComparison, refused);
  EXPECT_GT(refused, 40u);
  json["runs"][0]["builder"] = "sculptor";
  EXPECT_THROW(readComparison(written(json.dump())), formats::FormatError);
  json = toJson(fullComparison());
  json["runs"][0]["mesh"] = "another";
  EXPECT_THROW(readComparison(written(json.dump())), formats::FormatError);
}

TEST(Comparison, MeansAreOfMethodsWithATreeForEveryMesh) {
  Comparison comparison = fullComparison();
  comparison.meshes.push_back(comparison.meshes[0]);
  comparison.meshes[1].name = "molar";
  EXPECT_TRUE(geometricMeans(comparison).empty());
  pipeline::Run other = comparison.runs[0];
  other.mesh = "molar";
  other.processor_seconds = 4 * comparison.runs[0].processor_seconds;
  comparison.runs.push_back(other);
  const std::vector<MeanFigures> means = geometricMeans(comparison);
  ASSERT_EQ(means.size(), 1u);
  EXPECT_EQ(means[0].method, comparison.runs[0].method);
  EXPECT_NEAR(means[0].figures.processor_seconds, 2 * comparison.runs[0].processor_seconds, 1e-12);
}

}  // namespace
}  // namespace spheretree::pipeline
