// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/tree_job.h"

#include <algorithm>
#include <charconv>
#include <chrono>

#include "commands/builder_names.h"
#include "commands/command.h"
#include "commands/evaluation_json.h"
#include "commands/sound_mesh.h"
#include "json_text.h"
#include "spheretree/builder/evaluate_tree.h"
#include "spheretree/builder/provenance.h"
#include "spheretree/core/sphere_tree_codec.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/sphere_tree_file.h"

namespace spheretree::tool {
namespace {

constexpr const char* kRecordSchema = "spheretree.batch-record/1";
constexpr double kMeasuringEffort = 0.05;  // a look at every level that costs less than the build; `evaluate` measures in full

Hash128 hashOf(std::string_view text) { return builder::bytesHash(std::as_bytes(std::span(text))); }

std::string shortest(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

std::string siteText(const WorkSite& site, const Configuration& pose) {
  std::string text = site.key;
  for (const double x : {pose.position.x(), pose.position.y(), pose.position.z(), pose.orientation.w(), pose.orientation.x(),
                         pose.orientation.y(), pose.orientation.z()})
    text += "\n" + std::to_string(x);
  return text;
}

// Where every place has the same tolerance, the plain search for it is meant.
void grade(builder::BuildSettings& settings, std::vector<double> tolerances) {
  const auto [least, most] = std::minmax_element(tolerances.begin(), tolerances.end());
  settings.tolerance_mm = *least;
  if (*least < *most) settings.tolerance_of_triangle_mm = std::move(tolerances);
}

// The tolerances say no more than where an overhang matters less, and by how much.
void useAllLeaves(builder::BuildSettings& settings) {
  constexpr double kUnreached = 1e-6;  // of the least tolerance: no leaves are spared for it
  const double less = (1 - kUnreached) * settings.tolerance_mm;
  for (double& t : settings.tolerance_of_triangle_mm) t -= less;
  settings.tolerance_mm = settings.tolerance_of_triangle_mm.empty() ? 0 : settings.tolerance_mm - less;
}

Json levelsOf(const builder::RepairedMesh& repaired, const SphereTree& tree, builder::Progress& progress) {
  builder::EvaluateSettings settings;
  settings.limits = false;
  settings.effort = kMeasuringEffort;
  builder::Evaluation evaluation = builder::evaluateTree(repaired.mesh, tree, settings, progress, repaired.to_cover);
  for (builder::LevelEvaluation& level : evaluation.levels) {
    // The builder's proof is often the tighter one of two, since this measure is short.
    const double proven = tree.statistics[static_cast<std::size_t>(level.level)].overhang_bound;
    if (proven >= 0) level.overhang.bound = std::min(proven, level.overhang.bound);
  }
  return evaluationJson(evaluation).at("levels");
}

}  // namespace

std::shared_ptr<const MeshStore::File> MeshStore::read(const std::filesystem::path& path, double unit_mm) {
  Entry* entry = nullptr;
  {
    const std::lock_guard lock(mutex_);
    std::unique_ptr<Entry>& slot = entries_[{path, unit_mm}];
    if (!slot) slot = std::make_unique<Entry>();
    entry = slot.get();
  }
  const std::lock_guard lock(entry->reading);  // others go on with other files
  if (!entry->file) {
    auto file = std::make_shared<File>();
    file->mesh = formats::readMesh(path, unit_mm);
    // A .gltf may keep its numbers in other files, whose change its own bytes do not show.
    file->hash = file->mesh.format == "glTF" ? builder::meshHash(file->mesh.mesh) : builder::bytesHash(formats::readFile(path));
    entry->file = std::move(file);
  }
  return entry->file;
}

builder::BuildSettings buildSettings(const formats::TreeSettings& settings) {
  builder::BuildSettings out;
  if (settings.builder) out.builder = byName(kBuilders, *settings.builder);
  if (settings.quality) out.quality = byName(kQualities, *settings.quality);
  if (settings.levels) out.levels = *settings.levels;
  if (settings.branching) out.branching = *settings.branching;
  if (settings.tolerance_mm) out.tolerance_mm = *settings.tolerance_mm;
  if (settings.seed) out.seed = *settings.seed;
  return out;
}

std::string TreeJob::meshKey() const {
  return toHex(hashOf(kGenerator + "\n" + toHex(file->hash) + "\n" + part + '\0' + std::to_string(file->mesh.unit_mm) + "\n" + repair));
}

std::string TreeJob::key() const {
  return toHex(hashOf(meshKey() + "\n" + kRecordSchema + "\n" + builder::settingsText(settings) + (site ? siteText(*site, pose) : "") +
                      (scale == 1 ? "" : "\nscale=" + shortest(scale))));
}

builder::RepairedMesh TreeJob::solid(std::vector<std::string>& steps, builder::Progress& progress) const {
  const TriangleMesh input = part.empty() ? file->mesh.mesh : formats::selectPart(file->mesh.mesh, part);
  progress.check();
  return soundMesh(input, path.string() + (part.empty() ? "" : " part " + part), repairKind(repair), steps, progress);
}

TreeResult TreeJob::run(builder::Progress& progress) const {
  const auto begun = std::chrono::steady_clock::now();
  std::vector<std::string> steps;
  const builder::RepairedMesh repaired = solid(steps, progress);
  const TriangleMesh& mesh = repaired.mesh;
  progress.check();
  builder::BuildSettings own = settings;
  own.unit_mm = file->mesh.unit_mm;
  const bool is_graded = site && settings.tolerance_mm > 0 && settings.builder == BuilderKind::Cover;
  if (is_graded) grade(own, tolerancesAt(*site, inWorld(mesh, pose), settings.tolerance_mm, scale));
  const double least_tolerance = own.tolerance_mm;
  if (own.most_leaves > 0) useAllLeaves(own);
  builder::BuildResult built = builder::buildSphereTree(mesh, own, progress, repaired.to_cover);

  TreeResult result;
  result.record = {{"triangles", mesh.triangles.size()},
                   {"leaves", built.statistics.levels.back().spheres},
                   {"nodes", built.tree.nodeCount()},
                   {"diagonal_mm", built.tree.provenance.diagonal_mm},
                   {"tolerance_mm", settings.tolerance_mm > 0 ? Json(settings.tolerance_mm) : Json(nullptr)},
                   {"tolerance_met", settings.tolerance_mm > 0 ? Json(built.statistics.tolerance_met) : Json(nullptr)},
                   {"certified", true},
                   {"repair", steps},
                   {"notes", file->mesh.notes},
                   {"levels", levelsOf(repaired, built.tree, progress)}};
  if (own.most_leaves > 0) {
    const double wanted = settings.tolerance_mm > 0 ? settings.tolerance_mm : 1;
    const double met = built.statistics.least_tolerance_mm;
    // Of a graded tree: every tolerance is met if all are multiplied by this.
    const double ratio = is_graded ? scale * std::max(1.0, met / least_tolerance) : met / wanted;
    result.record["tolerance_met"] = settings.tolerance_mm > 0 ? Json(ratio <= 1) : Json(nullptr);
    result.record["tolerance_ratio"] = ratio;
    if (is_graded) result.record["least_met_mm"] = met;
  }
  if (is_graded) result.record["least_tolerance_mm"] = least_tolerance;
  if (site) result.record["work"] = workFigures(*site, mesh, pose, built.tree);
  result.tree = std::move(built.tree);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return result;
}

std::optional<TreeResult> TreeCache::find(const std::string& key) const {
  const std::filesystem::path tree = folder_ / (key + ".stree"), record = folder_ / (key + ".json");
  std::error_code ignored;
  if (!std::filesystem::exists(record, ignored) || !std::filesystem::exists(tree, ignored)) return std::nullopt;
  try {
    const std::vector<std::byte> bytes = formats::readFile(tree), text = formats::readFile(record);
    const auto* begin = reinterpret_cast<const char*>(text.data());
    Json json = Json::parse(begin, begin + text.size());
    if (json.at("schema") != kRecordSchema || json.at("tree_hash") != toHex(builder::bytesHash(bytes))) return std::nullopt;
    TreeResult result;
    result.tree = formats::parseSphereTree(bytes, tree.string());
    result.record = json.at("record");
    result.seconds = json.at("seconds").get<double>();
    return result;
  } catch (const formats::FileError&) {  // whatever is wrong with an entry: it is built again
  } catch (const formats::FormatError&) {
  } catch (const nlohmann::json::exception&) {
  }
  return std::nullopt;
}

void TreeCache::prepare() const {
  formats::makeFolder(folder_);
  formats::checkWritable(folder_ / "record.json");
}

void TreeCache::store(const std::string& key, const TreeResult& result) const {
  const std::vector<std::byte> bytes = encodeSphereTree(result.tree);
  // The tree first: a record without its tree is no entry, and neither is one whose hash does not fit.
  formats::writeWhole(folder_ / (key + ".stree"), bytes);
  const Json json{
      {"schema", kRecordSchema}, {"tree_hash", toHex(builder::bytesHash(bytes))}, {"seconds", result.seconds}, {"record", result.record}};
  formats::writeWhole(folder_ / (key + ".json"), jsonText(json, 1) + "\n");
}

}  // namespace spheretree::tool
