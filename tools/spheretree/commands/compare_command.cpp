// SPDX-License-Identifier: GPL-3.0-or-later
// spheretree compare: every builder and quality on every mesh, speed against accuracy.
#include <cctype>
#include <cstdio>
#include <iostream>
#include <memory>
#include <set>

#include "commands/builder_names.h"
#include "commands/command.h"
#include "commands/common_options.h"
#include "commands/sound_mesh.h"
#include "comparison/comparison.h"
#include "comparison/comparison_page.h"
#include "json_text.h"
#include "page/chart.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/mesh_file.h"

namespace spheretree::tool {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostPageBytes = 2'000'000;

struct CompareOptions {
  std::vector<fs::path> meshes;
  fs::path output;
  std::vector<std::string> builders = namesOf(kBuilders), qualities = namesOf(kQualities);
  std::string unit;
  int rotations = 0;  // for the table of stability
  builder::BuildSettings settings;
};

/// The file's name without its ending, safe in file names and CSV, different from those in `taken`.
std::string nameOf(const fs::path& file, std::set<std::string>& taken) {
  std::string name = file.stem().string();
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-' && c != '_') c = '_';
  std::string unique = name;
  for (int k = 2; !taken.insert(unique).second; ++k) unique = name + "-" + std::to_string(k);
  return unique;
}

std::vector<ComparedMesh> readMeshes(const CompareOptions& options, bool quiet, builder::Progress& progress) {
  std::vector<ComparedMesh> out;
  std::set<std::string> taken;
  for (const fs::path& file : options.meshes) {
    progress.stage("read " + file.filename().string());
    progress.check();
    std::vector<std::string> notes;
    builder::RepairedMesh mesh =
        soundMesh(formats::readMesh(file, formats::unitInMm(options.unit)).mesh, file.string(), builder::RepairKind::Auto, notes, progress);
    if (!quiet)
      for (const std::string& note : notes) std::cerr << file.string() << ": " << note << '\n';
    out.push_back({nameOf(file, taken), fs::absolute(file).lexically_normal(), std::move(mesh.mesh), std::move(mesh.to_cover)});
  }
  return out;
}

void makeFolders(const fs::path& output) {
  for (const char* inner : {"runs", "trees"}) formats::makeFolder(output / inner);
  formats::checkWritable(output / "compare.json");
}

void printMeans(const Json& means) {
  std::printf("Geometric means, leaves; D is the diagonal of a mesh\n");
  std::printf("builder   quality   processor [s]  worst overhang [%% D]  p99 [%% D]  excess volume [%%]\n");
  for (const Json& m : means)
    std::printf("%-9s %-9s %13s  %20s  %9s  %17s\n", m["builder"].get<std::string>().c_str(), m["quality"].get<std::string>().c_str(),
                shortNumber(m["processor_seconds"].get<double>()).c_str(), shortNumber(m["overhang_percent"].get<double>()).c_str(),
                shortNumber(m["p99_percent"].get<double>()).c_str(), shortNumber(m["excess_percent"].get<double>()).c_str());
}

int compare(const CompareOptions& options, bool quiet, builder::Progress& progress) {
  makeFolders(options.output);
  const std::vector<ComparedMesh> meshes = readMeshes(options, quiet, progress);
  std::vector<BuilderKind> builders;
  std::vector<Quality> qualities;
  for (const std::string& name : options.builders) builders.push_back(byName(kBuilders, name));
  for (const std::string& name : options.qualities) qualities.push_back(byName(kQualities, name));

  const std::vector<Method> what = methods(builders, qualities);
  Json comparison = compareBuilders(meshes, what, options.settings, options.output, progress);
  if (options.rotations > 0)
    comparison["stability"] = compareStability(meshes, what, options.settings, options.rotations, options.output, progress);
  for (Json& mesh : comparison["meshes"]) mesh["unit_mm"] = formats::unitInMm(options.unit);
  comparison["geometric_means"] = geometricMeans(comparison);
  const std::string page = comparisonPage(comparison, options.output, kMostPageBytes, progress);
  progress.check();
  formats::writeWhole(options.output / "compare.csv", comparisonCsv(comparison));
  writeComparisonCharts(comparison, options.output);
  formats::writeWhole(options.output / "index.html", page);
  formats::writeWhole(options.output / "compare.json", jsonText(comparison, 1) + "\n");

  printMeans(comparison["geometric_means"]);
  std::size_t failed = 0;
  for (const Json& run : comparison["runs"])
    if (run["status"] != "built") {
      ++failed;
      std::cerr << "spheretree: " << run["mesh"].get<std::string>() << ", " << run["builder"].get<std::string>() << " "
                << run["quality"].get<std::string>() << ": " << run["error"].get<std::string>() << '\n';
    }
  std::printf("%s: open this page in a browser\n", (options.output / "index.html").c_str());
  return failed > 0 ? kExitPartlyFailed : kExitOk;
}

int runCompare(const CompareOptions& options, bool quiet, builder::Progress& progress) try {
  return compare(options, quiet, progress);
} catch (const builder::Cancelled&) {
  std::cerr << "spheretree: interrupted. The runs that were finished are kept; the same command goes on from there.\n";
  return kExitInterrupted;
}

}  // namespace

void addCompareCommand(Program& program) {
  const auto options = std::make_shared<CompareOptions>();
  CLI::App* app =
      addVerb(program, "compare", "Every builder and quality on every mesh: speed against accuracy, as a page, SVG, CSV and JSON",
              "spheretree compare tooth.obj probe.obj -o comparison --qualities standard",
              [options, &program](builder::Progress& progress) { return runCompare(*options, program.quiet, progress); });
  app->add_option("MESH", options->meshes, "Meshes: .obj, .stl, .ply, .off, .gltf or .glb")->required()->type_name("FILE...");
  app->add_option("-o,--output", options->output, "Folder of the results. One of a run that was stopped goes on from there")
      ->required()
      ->type_name("DIR");
  app->add_option("--builders", options->builders,
                  "By commas, of cover, combined, merge, burst, expand, spawn, grid, hubbard and octree; default all")
      ->type_name("LIST")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember(namesOf(kBuilders)));
  app->add_option("--qualities", options->qualities,
                  "By commas, of quick, standard and best; default all. The octree has none and runs once")
      ->type_name("LIST")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember(namesOf(kQualities)));
  addTreeSize(*app, options->settings.levels, options->settings.branching);
  app->add_option("--stability", options->rotations,
                  "Adds a table of how much the trees change when the mesh is turned (N times), shifted a little, reordered, scaled or "
                  "subdivided, 0 to 1000; default 0: none. 24 builds every tree 43 times")
      ->type_name("N")
      ->check(CLI::Range(0, 1000));
  addUnit(*app, options->unit);
  addSeed(*app, options->settings.seed, "all random choices");
  addThreads(*app, options->settings.threads);
}

}  // namespace spheretree::tool
