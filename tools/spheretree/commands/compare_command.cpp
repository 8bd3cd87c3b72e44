// SPDX-License-Identifier: GPL-3.0-or-later
// spheretree compare: every builder and quality on every mesh, speed against accuracy.
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <memory>
#include <set>

#include "input/tree_input.h"
#include "options/command.h"
#include "options/common_options.h"
#include "page/chart.h"
#include "page/comparison_page.h"
#include "pipeline/builder_names.h"
#include "pipeline/comparison/comparison.h"
#include "pipeline/sound_mesh.h"
#include "robot/files/sphere_file.h"
#include "run_files.h"
#include "spheretree/formats/csv_table.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/mesh_file.h"
#include "terminal.h"

namespace spheretree::tool {
namespace {

namespace fs = std::filesystem;
using pipeline::ComparedMesh;
using pipeline::Comparison;
using pipeline::MeanFigures;
using pipeline::Run;

constexpr std::size_t kMaxPageBytes = 2'000'000;

struct CompareOptions {
  std::vector<fs::path> meshes;
  std::vector<std::string> builders = pipeline::namesOf(pipeline::kNamedBuilders), qualities = pipeline::namesOf(pipeline::kQualities);
  std::vector<fs::path> spheres;  // of other programs
  fs::path against;               // a list of such files with their times
  std::string unit, spheres_unit;
  pipeline::ComparisonSettings settings;
};

/// The file's name without its extension, safe in file names and CSV, different from those in `taken`.
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
  std::set<std::string> taken{"comparison"};  // the name of the chart of all meshes
  for (const fs::path& file : options.meshes) {
    progress.stage("read " + file.filename().string());
    progress.check();
    std::vector<std::string> notes;
    const formats::MeshFile read = pipeline::readMeshIn(file, options.unit);
    builder::RepairedMesh mesh = pipeline::soundMesh(read.mesh, file.string(), builder::RepairKind::Auto, notes, progress);
    if (!quiet)
      for (const std::string& note : notes) say(file.string() + ": " + note);
    out.push_back(
        {nameOf(file, taken), fs::absolute(file).lexically_normal(), read.unit_mm, std::move(mesh.mesh), std::move(mesh.to_cover)});
  }
  return out;
}

/// Adds the rows of a list of other programs' spheres: columns name, mesh, seconds, file; the file is relative to the
/// list, and the mesh is the name of its file without the ending.
void addAgainst(const CompareOptions& options, std::vector<ComparedMesh>& meshes) {
  if (options.against.empty()) return;
  const std::vector<std::byte> bytes = formats::readFile(options.against, formats::kMaxFileBytes);
  formats::CsvTable table({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, options.against.string());
  constexpr const char* kAdvice = "The first line has to be name,mesh,seconds,file";
  const std::size_t name = table.require("name", kAdvice), mesh = table.require("mesh", kAdvice),
                    seconds = table.require("seconds", kAdvice), file = table.require("file", kAdvice);
  while (table.next()) {
    const auto compared = std::ranges::find_if(meshes, [&](const ComparedMesh& m) { return m.file.stem() == table.field(mesh); });
    if (compared == meshes.end()) table.failField(mesh, "not the name of a mesh of this comparison, without the ending");
    const double time = table.number(seconds);
    if (!(time > 0)) table.failField(seconds, "not a time above 0");
    const fs::path path = fs::absolute(options.against).parent_path() / table.field(file);
    pipeline::OtherSpheres other{std::string(table.field(name)), path.lexically_normal(), "", {}, time};
    if (endingOf(path) == ".sph" || endingOf(path) == ".stree") {
      const SphereTree tree = readTree(path);
      robot::SphereSet set;
      for (const std::uint32_t node : levelSet(tree, tree.levelCount() - 1)) {
        const Sphere& s = tree.cover[node];
        set.balls.push_back({Eigen::Vector3d(s.x, s.y, s.z) + Eigen::Vector3d(tree.origin_mm.data()), double{s.radius}});
      }
      other.level = robot::levelOf(set);
      other.format = endingOf(path).substr(1);
    } else {
      const robot::SphereFile read = robot::readSphereFile(path, spheresUnit(options.spheres_unit));
      if (read.sets.size() != 1) table.failField(file, "a file of " + counted(read.sets.size(), "link") + "; it must have one");
      other.level = robot::levelOf(read.sets[0]);
      other.format = read.format;
    }
    compared->others.push_back(std::move(other));
  }
}

/// Assigns other programs' spheres to their meshes: those of the link that has the name of the mesh's file, or, if
/// there is only one mesh, the only spheres of a file.
void addSpheres(const CompareOptions& options, std::vector<ComparedMesh>& meshes, bool quiet) {
  std::vector<std::set<std::string>> taken(meshes.size(), {options.builders.begin(), options.builders.end()});
  for (const fs::path& file : options.spheres) {
    const robot::SphereFile read = robot::readSphereFile(file, spheresUnit(options.spheres_unit));
    if (!quiet && read.without_volume > 0)
      say(file.string() + ": " + counted(read.without_volume, "sphere") + " with a radius of 0 or below left out.");
    bool is_used = false;
    for (std::size_t m = 0; m < meshes.size(); ++m)
      for (const robot::SphereSet& set : read.sets) {
        const bool is_only = read.sets.size() == 1 && meshes.size() == 1;
        if (!is_only && set.link != meshes[m].file.stem()) continue;
        meshes[m].others.push_back({nameOf(file, taken[m]), fs::absolute(file).lexically_normal(), read.format, robot::levelOf(set)});
        is_used = true;
      }
    if (is_used) continue;
    std::string links;
    for (const robot::SphereSet& set : read.sets) links += (links.empty() ? "" : ", ") + (set.link.empty() ? "(without a name)" : set.link);
    throw formats::FormatError(file.string() + ": has spheres for " + links +
                               ", and no mesh has this name. Give the file of a mesh the name of its link.");
  }
}

/// Declares what this command writes in addition to pipeline::runComparison().
void declareOutputs(const CompareOptions& options, const std::vector<ComparedMesh>& meshes, const RunFiles& files) {
  const fs::path& folder = options.settings.folder;
  files.willMake(folder / "index.html");
  for (const char* ending : {".svg", ".pdf"}) {
    files.willMake(folder / (std::string("comparison") + ending));
    for (const ComparedMesh& mesh : meshes) files.willMake(folder / (mesh.name + ending));
  }
}

void printMeans(const std::vector<MeanFigures>& means) {
  printResult("Geometric means, leaves; D is the diagonal of a mesh\n");
  printResult("builder          quality   processor [s]  worst overhang [%% D]  p99 [%% D]  excess volume [%%]\n");
  for (const MeanFigures& m : means)
    printResult("%-16s %-9s %13s  %20s  %9s  %17s\n", name(m.method.builder).c_str(), std::string(name(m.method.quality)).c_str(),
                shortNumber(m.figures.processor_seconds).c_str(), shortNumber(m.figures.overhang_percent).c_str(),
                shortNumber(m.figures.p99_percent).c_str(), shortNumber(m.figures.excess_percent).c_str());
}

int compare(CompareOptions options, bool quiet, builder::Progress& progress) {
  const fs::path& folder = options.settings.folder;
  const RunFiles files;
  for (const fs::path& mesh : options.meshes) files.willRead(mesh);
  for (const fs::path& spheres : options.spheres) files.willRead(spheres);
  files.willRead(options.against);
  files.makeFolder(folder);
  formats::checkWritable(folder / "compare.json");  // before the meshes are read, which may take long
  std::vector<ComparedMesh> meshes = readMeshes(options, quiet, progress);
  addSpheres(options, meshes, quiet);
  addAgainst(options, meshes);
  declareOutputs(options, meshes, files);
  std::vector<pipeline::NamedBuilder> builders;
  std::vector<builder::Quality> qualities;
  for (const std::string& name : options.builders) builders.push_back(pipeline::byName(pipeline::kNamedBuilders, name));
  for (const std::string& name : options.qualities) qualities.push_back(pipeline::byName(pipeline::kQualities, name));
  options.settings.methods = pipeline::methods(builders, qualities);

  const Comparison comparison = pipeline::runComparison(meshes, options.settings, progress);
  const std::string page = comparisonPage(comparison, folder, kMaxPageBytes, progress);
  progress.check();
  if (const std::string missing = writeComparisonCharts(comparison, folder, progress); !missing.empty()) say("spheretree: " + missing);
  formats::writeWhole(folder / "index.html", page);

  printMeans(comparison.means);
  std::size_t failed = 0;
  for (const Run& run : comparison.runs) {
    if (run.isBuilt()) continue;
    ++failed;
    say("spheretree: " + run.mesh + ", " + name(run.method.builder) + " " + std::string(name(run.method.quality)) + ": " + run.error);
  }
  printResult("%s: open this page in a browser\n", plainText((folder / "index.html").string()).c_str());
  return failed > 0 ? kExitPartlyFailed : kExitOk;
}

int runCompare(const CompareOptions& options, bool quiet, builder::Progress& progress) try {
  return compare(options, quiet, progress);
} catch (const builder::Cancelled&) {
  return explain(kProgram, kExitInterrupted, "interrupted. The runs that were finished are kept; the same command goes on from there.");
}

}  // namespace

void addCompareCommand(Program& program) {
  const auto options = std::make_shared<CompareOptions>();
  CLI::App* app = addVerb(program, "compare",
                          "Build every mesh with every builder and quality, and report speed against accuracy as HTML, SVG, CSV and JSON",
                          "spheretree compare tooth.obj probe.obj -o comparison --qualities standard",
                          [options, &program](builder::Progress& progress) { return runCompare(*options, program.quiet, progress); });
  app->add_option("MESH", options->meshes, "Meshes: .obj, .stl, .ply, .off, .gltf or .glb")->required()->type_name("FILE...");
  app->add_option("-o,--output", options->settings.folder, "Folder of the results; the folder of an interrupted run is continued")
      ->required()
      ->type_name("DIR");
  app->add_option(
         "--builders", options->builders,
         "Builders, separated by commas: cover, and combined, merge, burst, expand, spawn, grid, hubbard and octree, each also with "
         "the cover search, as merge+search; default all")
      ->type_name("LIST")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember(pipeline::namesOf(pipeline::kNamedBuilders)));
  app->add_option(
         "--qualities", options->qualities,
         "Qualities, separated by commas, of quick, standard and best; default all. The octree does not depend on them and runs once")
      ->type_name("LIST")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember(pipeline::namesOf(pipeline::kQualities)));
  app->add_option("--spheres", options->spheres,
                  "Also show the spheres of other programs in the charts: files of cuRobo, foam, ballpark, MorphIt, XRDF, SRDF, URDF or "
                  "MJCF; if a file has several links, the link that is named like the mesh file is used")
      ->type_name("FILE...");
  app->add_option("--against", options->against,
                  "List of other programs' spheres with their times, for the chart of speed: CSV with the columns name, mesh (its file "
                  "without the ending), seconds and file (.sph, .stree, or as for --spheres)")
      ->type_name("FILE");
  addSpheresUnit(*app, options->spheres_unit);
  addTreeSize(*app, options->settings.build.levels, options->settings.build.branching);
  app->add_option("--sensitivity,--stability", options->settings.rotations,
                  "Add a table of how much the trees change when the mesh is rotated (N times), shifted slightly, reordered, scaled or "
                  "subdivided, 0 to 1000; default 0: no table. With 24 every tree is built 43 times")
      ->type_name("N")
      ->check(CLI::Range(0, 1000));
  addUnit(*app, options->unit);
  addSeed(*app, options->settings.build.seed, "all random choices");
  addThreads(*app, options->settings.build.threads);
  addForce(*app, program);
}

}  // namespace spheretree::tool
