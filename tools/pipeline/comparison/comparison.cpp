// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/comparison/comparison.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "generator.h"
#include "json_text.h"
#include "measure/cover_limits.h"
#include "pipeline/comparison/comparison_json.h"
#include "run_files.h"
#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/builder/evaluate_tree.h"
#include "spheretree/builder/provenance.h"
#include "spheretree/core/mesh_edit.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/sphere_tree_file.h"

namespace spheretree::pipeline {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using builder::BuilderKind;
using builder::Quality;
using tool::kGenerator;

/// Progress of one run among many: progress within the run does not move the bar.
class RunProgress : public builder::Progress {
 public:
  RunProgress(builder::Progress& whole, double done) : Progress(&whole), whole_(whole), done_(done) {}
  void stage(std::string_view) override { advance(0); }
  void advance(double) override { whole_.advance(done_); }

 private:
  builder::Progress& whole_;
  double done_;
};

/// The content of a file from an earlier run, if the same program made it from the same input; otherwise empty.
template <class FromJson>
auto finished(const fs::path& file, const Json& key, FromJson&& fromJson) -> std::optional<decltype(fromJson(key))> {
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return std::nullopt;
  const std::vector<std::byte> bytes = formats::readFile(file, formats::kMaxFileBytes, formats::FileRole::Working);
  const char* text = reinterpret_cast<const char*>(bytes.data());
  try {
    const Json found = Json::parse(text, text + bytes.size());
    if (found.is_object() && found.value("key", Json()) == key) return fromJson(found);
  } catch (const nlohmann::json::exception&) {  // truncated or edited by hand: it is computed again
  } catch (const formats::FormatError&) {
  }
  return std::nullopt;
}

void store(const fs::path& file, const Json& key, const Json& content) {
  Json out{{"key", key}};
  out.update(content);
  formats::writeWhole(file, tool::jsonText(out, 1) + "\n", formats::FileRole::Working);
}

fs::path fileOf(const fs::path& folder, const std::string& id) { return folder / "runs" / (id + ".json"); }

MeshFigures measureMesh(const ComparedMesh& compared, const Json& key, const ComparisonSettings& settings, builder::Progress& progress) {
  const fs::path file = fileOf(settings.folder, compared.name);
  const std::optional<MeshFigures> earlier = finished(file, key, [](const Json& j) { return meshFiguresFromJson(j.at("mesh")); });
  const bool is_known = earlier.has_value();
  MeshFigures mesh = earlier.value_or(MeshFigures{});
  if (!is_known) {
    const builder::DistanceField field(compared.mesh);
    mesh.triangles = compared.mesh.triangles.size();
    mesh.diagonal_mm = field.diagonal();
    mesh.area_mm2 = field.area();
    mesh.volume_mm3 = field.volume();
    mesh.leaves = std::pow(settings.build.branching, settings.build.levels - 1);
    mesh.limits =
        builder::coverLimits(compared.mesh, field, static_cast<std::size_t>(mesh.leaves), {.seed = settings.build.seed}, progress);
  }
  mesh.name = compared.name;
  mesh.file = compared.file;  // its current path: the file may have moved since an earlier run
  mesh.unit_mm = compared.unit_mm;
  if (!is_known) store(file, key, {{"mesh", toJson(mesh)}});
  return mesh;
}

std::vector<OtherFigures> measureOthers(const ComparedMesh& compared, const builder::BuildSettings& build, builder::Progress& progress) {
  std::vector<OtherFigures> out;
  for (const OtherSpheres& other : compared.others) {
    builder::Evaluation evaluation = builder::evaluateTree(
        compared.mesh, other.level, {.limits = false, .seed = build.seed, .threads = build.threads}, progress, compared.to_cover);
    out.push_back({other.name, other.file, other.format, std::move(evaluation.levels.back()), other.seconds});
  }
  return out;
}

struct Job {
  const ComparedMesh* compared;
  builder::BuildSettings settings;
  Json key;
  std::string id;
  Run run;
  bool is_finished = false;
  double work() const { return 1 + static_cast<double>(compared->mesh.triangles.size()) / 20000; }  // in arbitrary units
};

std::string hashOfMesh(const ComparedMesh& compared) { return toHex(builder::meshHash(joined(compared.mesh, compared.to_cover))); }

Job jobOf(const ComparedMesh& compared, const Method& method, const ComparisonSettings& settings) {
  Job job{&compared, settings.build, {}, {}, {}, false};
  job.settings.builder = method.builder.kind;
  job.settings.search = method.builder.search;
  job.settings.skin = false;  // leaves are compared, and no skin is needed
  job.settings.quality = method.quality;
  job.id = compared.name + "." + idOf(method);
  job.key = {{"generator", kGenerator}, {"mesh", hashOfMesh(compared)}, {"settings", toHex(builder::settingsHash(job.settings))}};
  if (std::optional<Run> earlier = finished(fileOf(settings.folder, job.id), job.key, runFromJson))
    if (!earlier->isBuilt() || fs::exists(settings.folder / earlier->tree)) {
      job.run = std::move(*earlier);
      job.is_finished = true;
      return job;
    }
  job.run.mesh = compared.name;
  job.run.method = method;
  return job;
}

void buildAndMeasure(Job& job, const fs::path& folder, builder::Progress& progress) {
  const ComparedMesh& compared = *job.compared;
  const auto begun = std::chrono::steady_clock::now();
  const std::clock_t processor = std::clock();
  const builder::BuildResult result = builder::buildSphereTree(compared.mesh, job.settings, progress, compared.to_cover);
  job.run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  job.run.processor_seconds = static_cast<double>(std::clock() - processor) / CLOCKS_PER_SEC;
  job.run.nodes = result.tree.nodeCount();
  job.run.tree = fs::path("trees") / (job.id + ".stree");
  formats::writeSphereTree(folder / job.run.tree, result.tree);
  builder::Evaluation evaluation =
      builder::evaluateTree(compared.mesh, result.tree, {.limits = false, .seed = job.settings.seed, .threads = job.settings.threads},
                            progress, compared.to_cover);
  job.run.levels = std::move(evaluation.levels);
  job.run.hierarchy = evaluation.hierarchy;
}

/// Runs the unfinished jobs, one after the other: times are compared, and parallel builds would disturb each other.
void runJobs(std::vector<Job>& jobs, const fs::path& folder, builder::Progress& progress) {
  double total = 0, done = 0;
  std::size_t count = 0;
  for (const Job& job : jobs)
    if (!job.is_finished) total += job.work(), ++count;
  progress.stage(std::to_string(count) + " runs");
  for (Job& job : jobs) {
    if (job.is_finished) continue;
    progress.check();
    RunProgress run_progress(progress, done / total);
    try {
      buildAndMeasure(job, folder, run_progress);
    } catch (const builder::BuildError& error) {
      job.run.error = error.what();
    }
    progress.check();
    store(fileOf(folder, job.id), job.key, toJson(job.run));
    done += job.work();
    progress.advance(done / total);
  }
}

Sensitivity sensitivityOf(const ComparedMesh& compared, const Method& method, const ComparisonSettings& settings,
                          builder::Progress& progress) {
  builder::SensitivitySettings tried;
  tried.rotations = settings.rotations;
  tried.others = std::clamp(settings.rotations / 6, 1, tried.others);
  tried.seed = settings.build.seed;
  builder::BuildSettings build = settings.build;
  build.builder = method.builder.kind;
  build.search = method.builder.search;
  build.skin = false;
  build.quality = method.quality;
  const fs::path file = fileOf(settings.folder, compared.name + "." + idOf(method) + ".stability");
  const Json key{{"generator", kGenerator},
                 {"mesh", toHex(builder::meshHash(compared.mesh))},
                 {"settings", toHex(builder::settingsHash(build))},
                 {"rotations", settings.rotations}};
  if (std::optional<Sensitivity> earlier = finished(file, key, sensitivityFromJson)) return *earlier;
  Sensitivity out{compared.name, method, {}, {}};
  try {
    out.rows = builder::measureSensitivity(compared.mesh, build, tried, progress);
  } catch (const builder::BuildError& error) {
    out.error = error.what();
  }
  store(file, key, toJson(out));
  return out;
}

std::vector<Sensitivity> sensitivities(const std::vector<ComparedMesh>& meshes, const ComparisonSettings& settings,
                                       builder::Progress& progress) {
  std::vector<Sensitivity> out;
  const auto total = static_cast<double>(meshes.size() * settings.methods.size());
  progress.stage("sensitivity");
  for (const ComparedMesh& compared : meshes)
    for (const Method& method : settings.methods) {
      progress.check();
      RunProgress run_progress(progress, static_cast<double>(out.size()) / total);
      out.push_back(sensitivityOf(compared, method, settings, run_progress));
    }
  return out;
}

std::string processorName() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.starts_with("model name")) {
      const std::size_t colon = line.find(": ");
      if (colon != std::string::npos) return line.substr(colon + 2);
    }
  return "unknown processor";
}

}  // namespace

std::vector<Method> methods(const std::vector<NamedBuilder>& builders, const std::vector<Quality>& qualities) {
  std::vector<Method> out;
  const auto add = [&](const NamedBuilder& builder, Quality quality) {
    if (const Method method{builder, quality}; std::find(out.begin(), out.end(), method) == out.end()) out.push_back(method);
  };
  for (const NamedBuilder& builder : builders) {
    if (builder == NamedBuilder{BuilderKind::Octree}) {
      const bool standard = std::find(qualities.begin(), qualities.end(), Quality::Standard) != qualities.end();
      add(builder, standard || qualities.empty() ? Quality::Standard : qualities.front());
      continue;
    }
    for (const Quality quality : qualities) add(builder, quality);
  }
  return out;
}

namespace {

/// Before the first build: declares everything that runComparison() writes.
void declareOutputs(const std::vector<ComparedMesh>& meshes, const ComparisonSettings& settings, const tool::RunFiles& files) {
  for (const char* name : {"compare.csv", "compare.json"}) files.willMake(settings.folder / name);
  for (const ComparedMesh& mesh : meshes) {
    files.willMake(fileOf(settings.folder, mesh.name));
    for (const Method& method : settings.methods) {
      const std::string id = mesh.name + "." + idOf(method);
      files.willMake(fileOf(settings.folder, id));
      files.willMake(settings.folder / "trees" / (id + ".stree"));
    }
  }
}

}  // namespace

Comparison runComparison(const std::vector<ComparedMesh>& meshes, const ComparisonSettings& settings, builder::Progress& progress) {
  const tool::RunFiles files(progress);
  for (const char* inner : {"runs", "trees"}) files.makeFolder(settings.folder / inner);
  declareOutputs(meshes, settings, files);
  const builder::BuildSettings& build = settings.build;
  Comparison out;
  out.generator = kGenerator;
  out.processor = processorName();
  out.threads = build.threads > 0 ? build.threads : static_cast<int>(std::thread::hardware_concurrency());
  out.levels = build.levels;
  out.branching = build.branching;
  out.seed = build.seed;
  std::vector<Job> jobs;
  for (const ComparedMesh& compared : meshes) {
    progress.stage("limits of " + compared.name);
    const Json key{{"generator", kGenerator},
                   {"mesh", hashOfMesh(compared)},
                   {"settings", {{"levels", build.levels}, {"branching", build.branching}, {"seed", build.seed}}}};
    out.meshes.push_back(measureMesh(compared, key, settings, progress));
    out.meshes.back().others = measureOthers(compared, build, progress);
    progress.check();
    for (const Method& method : settings.methods) jobs.push_back(jobOf(compared, method, settings));
  }
  runJobs(jobs, settings.folder, progress);
  for (Job& job : jobs) out.runs.push_back(std::move(job.run));
  if (settings.rotations > 0) out.sensitivity = sensitivities(meshes, settings, progress);
  out.means = geometricMeans(out);
  formats::writeWhole(settings.folder / "compare.csv", comparisonCsv(out));
  formats::writeWhole(settings.folder / "compare.json", tool::jsonText(toJson(out), 1) + "\n");
  return out;
}

std::string comparisonCsv(const Comparison& comparison) {
  std::string out =
      "mesh,builder,quality,seconds,processor_seconds,level,spheres,overhang_max_mm,overhang_bound_mm,overhang_p99_mm,overhang_mean_mm,"
      "uncovered_fraction,max_gap_mm,excess_volume_fraction,missing_volume_fraction\n";
  const auto addLevel = [&out](const std::string& whose, const builder::LevelEvaluation& level) {
    out += whose;
    const builder::Overhang& overhang = level.overhang;
    for (const Json& value : {Json(level.level), Json(level.spheres), Json(overhang.max), Json(overhang.bound), Json(overhang.p99),
                              Json(overhang.mean), Json(level.coverage.uncovered_fraction), Json(level.coverage.max_gap),
                              Json(level.excess_volume_fraction), Json(level.missing_volume_fraction)})
      out += "," + value.dump();
    out += "\n";
  };
  for (const Run& run : comparison.runs)
    for (const builder::LevelEvaluation& level : run.levels)
      addLevel(run.mesh + "," + name(run.method.builder) + "," + std::string(name(run.method.quality)) + "," + Json(run.seconds).dump() +
                   "," + Json(run.processor_seconds).dump(),
               level);
  for (const MeshFigures& mesh : comparison.meshes)
    for (const OtherFigures& other : mesh.others)
      addLevel(mesh.name + "," + other.name + ",,," + (other.seconds > 0 ? Json(other.seconds).dump() : ""), other.level);
  return out;
}

}  // namespace spheretree::pipeline
