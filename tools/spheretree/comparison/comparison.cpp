// SPDX-License-Identifier: GPL-3.0-or-later
#include "comparison/comparison.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <fstream>
#include <thread>

#include "commands/builder_names.h"
#include "commands/command.h"
#include "commands/evaluation_json.h"
#include "json_text.h"
#include "measure/cover_limits.h"
#include "spheretree/builder/evaluate_tree.h"
#include "spheretree/builder/provenance.h"
#include "spheretree/builder/sensitivity.h"
#include "spheretree/core/mesh_edit.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/sphere_tree_file.h"

namespace spheretree::tool {
namespace {

namespace fs = std::filesystem;

/// One run of many: what happens within it does not move the bar, and Ctrl-C reaches it at its next step.
class RunProgress : public builder::Progress {
 public:
  RunProgress(builder::Progress& whole, double done) : whole_(whole), done_(done) {}
  void stage(std::string_view) override { advance(0); }
  void advance(double) override {
    if (whole_.cancelled()) cancel();
    whole_.advance(done_);
  }

 private:
  builder::Progress& whole_;
  double done_;
};

/// What a file of an earlier run says, if it was made from the same input by the same program; else null.
Json known(const fs::path& file, const Json& key) {
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return nullptr;
  const std::vector<std::byte> bytes = formats::readFile(file);
  const char* text = reinterpret_cast<const char*>(bytes.data());
  Json found = Json::parse(text, text + bytes.size(), nullptr, false);
  return found.is_object() && found.value("key", Json()) == key ? found : Json();
}

Json buildAndMeasure(const ComparedMesh& compared, const builder::BuildSettings& settings, const fs::path& tree_file,
                     builder::Progress& progress) {
  Json run;
  const auto begun = std::chrono::steady_clock::now();
  const std::clock_t processor = std::clock();
  const builder::BuildResult result = builder::buildSphereTree(compared.mesh, settings, progress, compared.to_cover);
  run["seconds"] = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  run["processor_seconds"] = static_cast<double>(std::clock() - processor) / CLOCKS_PER_SEC;
  run["nodes"] = result.tree.nodeCount();
  formats::writeSphereTree(tree_file, result.tree);
  const Json figures = evaluationJson(builder::evaluateTree(
      compared.mesh, result.tree, {.limits = false, .seed = settings.seed, .threads = settings.threads}, progress, compared.to_cover));
  run["levels"] = figures.at("levels");
  run["hierarchy"] = figures.at("hierarchy");
  return run;
}

Json meshEntry(const ComparedMesh& compared, const Json& key, const builder::BuildSettings& settings, const fs::path& file,
               builder::Progress& progress) {
  const Json earlier = known(file, key);
  if (!earlier.is_null()) return earlier.at("mesh");
  const builder::DistanceField field(compared.mesh);
  const double leaves = std::pow(settings.branching, settings.levels - 1);
  const builder::CoverLimits limits =
      builder::coverLimits(compared.mesh, field, static_cast<std::size_t>(leaves), {.seed = settings.seed}, progress);
  Json mesh{
      {"name", compared.name},
      {"file", compared.file.string()},
      {"triangles", compared.mesh.triangles.size()},
      {"diagonal_mm", field.diagonal()},
      {"area_mm2", field.area()},
      {"volume_mm3", field.volume()},
      {"limit_mm", {{"leaves", leaves}, {"h_fin", limits.h_fin}, {"h_low", limits.h_low}, {"h_low_in_range", limits.h_low_in_range}}}};
  formats::writeWhole(file, jsonText({{"key", key}, {"mesh", mesh}}, 1) + "\n");
  return mesh;
}

std::string idOf(const ComparedMesh& compared, const Method& method) {
  return compared.name + "." + std::string(name(method.builder)) + "." + std::string(name(method.quality));
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

std::vector<Method> methods(const std::vector<BuilderKind>& builders, const std::vector<Quality>& qualities) {
  std::vector<Method> out;
  const auto add = [&](BuilderKind builder, Quality quality) {
    const auto is_same = [&](const Method& m) { return m.builder == builder && m.quality == quality; };
    if (std::none_of(out.begin(), out.end(), is_same)) out.push_back({builder, quality});
  };
  for (const BuilderKind builder : builders) {
    if (builder == BuilderKind::Octree) {
      const bool standard = std::find(qualities.begin(), qualities.end(), Quality::Standard) != qualities.end();
      add(builder, standard || qualities.empty() ? Quality::Standard : qualities.front());
      continue;
    }
    for (const Quality quality : qualities) add(builder, quality);
  }
  return out;
}

Json compareBuilders(const std::vector<ComparedMesh>& meshes, const std::vector<Method>& what, const builder::BuildSettings& settings,
                     const fs::path& folder, builder::Progress& progress) {
  Json out{{"schema", "spheretree.comparison/1"},
           {"generator", kGenerator},
           {"machine",
            {{"processor", processorName()},
             {"threads", settings.threads > 0 ? settings.threads : static_cast<int>(std::thread::hardware_concurrency())}}},
           {"settings", {{"levels", settings.levels}, {"branching", settings.branching}, {"seed", settings.seed}}},
           {"meshes", Json::array()},
           {"runs", Json::array()}};
  struct Job {
    const ComparedMesh* compared;
    builder::BuildSettings settings;
    Json key;
    std::string id;
    fs::path tree;  // below `folder`
    Json run;       // null: still to be done
  };
  const auto fileOf = [&](const std::string& id) { return folder / "runs" / (id + ".json"); };
  const auto weight = [](const Job& job) { return 1 + static_cast<double>(job.compared->mesh.triangles.size()) / 20000; };
  std::vector<Job> jobs;
  double total = 0, done = 0;
  for (const ComparedMesh& compared : meshes) {
    progress.stage("limits of " + compared.name);
    const std::string mesh_hash = toHex(builder::meshHash(joined(compared.mesh, compared.to_cover)));
    const Json mesh_key{{"generator", kGenerator}, {"mesh", mesh_hash}, {"settings", out["settings"]}};
    out["meshes"].push_back(meshEntry(compared, mesh_key, settings, fileOf(compared.name), progress));
    progress.check();
    for (const Method& method : what) {
      Job job{&compared, settings, {}, {}, {}, {}};
      job.settings.builder = method.builder;
      job.settings.quality = method.quality;
      job.id = idOf(compared, method);
      job.tree = fs::path("trees") / (job.id + ".stree");
      job.key = {{"generator", kGenerator}, {"mesh", mesh_hash}, {"settings", toHex(builder::settingsHash(job.settings))}};
      job.run = known(fileOf(job.id), job.key);
      if (job.run.is_object() && job.run.value("status", "") == "built" && !fs::exists(folder / job.tree)) job.run = nullptr;
      if (job.run.is_null()) total += weight(job);
      jobs.push_back(std::move(job));
    }
  }
  progress.stage(std::to_string(std::count_if(jobs.begin(), jobs.end(), [](const Job& job) { return job.run.is_null(); })) + " runs");
  for (Job& job : jobs) {
    if (job.run.is_null()) {
      progress.check();
      RunProgress run_progress(progress, done / total);
      job.run = Json{
          {"key", job.key}, {"mesh", job.compared->name}, {"builder", name(job.settings.builder)}, {"quality", name(job.settings.quality)}};
      try {
        const Json figures = buildAndMeasure(*job.compared, job.settings, folder / job.tree, run_progress);
        job.run["status"] = "built";
        job.run["tree"] = job.tree.string();
        job.run.update(figures);
      } catch (const builder::BuildError& error) {
        job.run["status"] = "failed";
        job.run["error"] = error.what();
      }
      progress.check();
      formats::writeWhole(fileOf(job.id), jsonText(job.run, 1) + "\n");
      done += weight(job);
      progress.advance(done / total);
    }
    job.run.erase("key");
    out["runs"].push_back(std::move(job.run));
  }
  return out;
}

Json compareStability(const std::vector<ComparedMesh>& meshes, const std::vector<Method>& what, const builder::BuildSettings& settings,
                      int rotations, const fs::path& folder, builder::Progress& progress) {
  Json out = Json::array();
  builder::SensitivitySettings tried;
  tried.rotations = rotations;
  tried.others = std::clamp(rotations / 6, 1, tried.others);
  tried.seed = settings.seed;
  const auto total = static_cast<double>(meshes.size() * what.size());
  progress.stage("stability");
  for (const ComparedMesh& compared : meshes)
    for (const Method& method : what) {
      progress.check();
      RunProgress run_progress(progress, static_cast<double>(out.size()) / total);
      builder::BuildSettings build = settings;
      build.builder = method.builder;
      build.quality = method.quality;
      const fs::path file = folder / "runs" / (idOf(compared, method) + ".stability.json");
      const Json key{{"generator", kGenerator},
                     {"mesh", toHex(builder::meshHash(compared.mesh))},
                     {"settings", toHex(builder::settingsHash(build))},
                     {"rotations", rotations}};
      Json entry = known(file, key);
      if (entry.is_null()) {
        entry = Json{{"key", key}, {"mesh", compared.name}, {"builder", name(method.builder)}, {"quality", name(method.quality)}};
        try {
          entry["rows"] = Json::array();
          for (const builder::SensitivityRow& row : builder::measureSensitivity(compared.mesh, build, tried, run_progress))
            entry["rows"].push_back(
                {{"change", row.change}, {"cases", row.cases}, {"largest_change", row.largest_change}, {"same_spheres", row.same_spheres}});
        } catch (const builder::BuildError& error) {
          entry.erase("rows");
          entry["error"] = error.what();
        }
        formats::writeWhole(file, jsonText(entry, 1) + "\n");
      }
      entry.erase("key");
      out.push_back(std::move(entry));
    }
  return out;
}

std::string comparisonCsv(const Json& comparison) {
  std::string out =
      "mesh,builder,quality,seconds,processor_seconds,level,spheres,overhang_max_mm,overhang_bound_mm,overhang_p99_mm,overhang_mean_mm,"
      "uncovered_fraction,max_gap_mm,excess_volume_fraction,missing_volume_fraction\n";
  for (const Json& run : comparison.at("runs")) {
    if (run.at("status") != "built") continue;
    for (const Json& level : run.at("levels")) {
      out += run.at("mesh").get<std::string>() + "," + run.at("builder").get<std::string>() + "," + run.at("quality").get<std::string>();
      const Json& overhang = level.at("overhang_mm");
      for (const Json& value : {run.at("seconds"), run.at("processor_seconds"), level.at("level"), level.at("spheres"), overhang.at("max"),
                                overhang.at("bound"), overhang.at("p99"), overhang.at("mean"), level.at("uncovered_fraction"),
                                level.at("max_gap_mm"), level.at("excess_volume_fraction"), level.at("missing_volume_fraction")})
        out += "," + value.dump();
      out += "\n";
    }
  }
  return out;
}

}  // namespace spheretree::tool
