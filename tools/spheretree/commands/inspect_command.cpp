// SPDX-License-Identifier: GPL-3.0-or-later
// spheretree inspect: the content of a tree file, and whether the tree is sound.
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <span>
#include <vector>

#include "json_text.h"
#include "measure/evaluate_skin.h"
#include "options/command.h"
#include "pipeline/evaluation_json.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/sphere_tree_file.h"
#include "terminal.h"

namespace spheretree::tool {
namespace {

using Json = nlohmann::ordered_json;

struct InspectOptions {
  std::vector<std::filesystem::path> trees;
  bool json = false;
};

/// Compares the bounding spheres of a level's inner nodes with the smallest possible ones, and with the cover spheres.
struct Tightness {
  std::size_t inner_nodes = 0;
  double worst_over_smallest = 1;  // largest ratio of radii; 1: as small as possible
  double mean_over_cover = 1, worst_over_cover = 1;
};

std::vector<Tightness> measureTightness(const SphereTree& tree) {
  SphereTree smallest = tree;
  encloseDescendants(smallest);
  std::vector<Tightness> levels(static_cast<std::size_t>(tree.levelCount()));
  for (std::size_t level = 0; level < levels.size(); ++level) {
    Tightness& t = levels[level];
    double sum = 0;
    for (std::uint32_t i = tree.level_begin[level]; i < tree.level_begin[level + 1]; ++i) {
      if (tree.isLeaf(i)) continue;
      const double bound = tree.bound[tree.bound_index[i]].radius, cover = tree.cover[i].radius;
      t.worst_over_smallest = std::max(t.worst_over_smallest, bound / smallest.bound[tree.bound_index[i]].radius);
      t.worst_over_cover = std::max(t.worst_over_cover, bound / cover);
      sum += bound / cover;
      ++t.inner_nodes;
    }
    if (t.inner_nodes > 0) t.mean_over_cover = sum / static_cast<double>(t.inner_nodes);
  }
  return levels;
}

/// Facts about the file itself, which may have a newer minor version than this program writes.
struct FileFacts {
  std::size_t bytes = 0;
  std::string version;
};

FileFacts factsOf(std::span<const std::byte> bytes) {
  std::uint16_t version[2];
  std::memcpy(version, bytes.data() + 8, sizeof version);
  return {bytes.size(), std::to_string(version[0]) + "." + std::to_string(version[1])};
}

Json toJson(const SphereTree& tree, const FileFacts& file) {
  const Provenance& p = tree.provenance;
  Json out;
  out["schema"] = "spheretree.inspection/1";
  out["valid"] = true;
  out["bytes"] = file.bytes;
  out["format"] = file.version;
  out["nodes"] = tree.nodeCount();
  out["inner_nodes"] = tree.bound.size();
  out["branching"] = tree.branching;
  out["origin_mm"] = tree.origin_mm;
  out["builder"] = p.builder;
  out["quality"] = p.quality;
  out["generator"] = p.generator;
  out["unit_mm"] = p.unit_mm;
  out["tolerance_mm"] = p.tolerance_mm;
  if (p.work_overhang_mm > 0) out["work_overhang_mm"] = p.work_overhang_mm;
  out["seed"] = p.seed;
  out["mesh"] = {{"triangles", p.triangle_count},
                 {"diagonal_mm", p.diagonal_mm},
                 {"area_mm2", p.area_mm2},
                 {"volume_mm3", p.volume_mm3},
                 {"hash", toHex(p.mesh_hash)}};
  out["settings_hash"] = toHex(p.settings_hash);
  out["skin"] = tree.skin.empty() ? Json(nullptr) : pipeline::skinJson(builder::skinFigures(tree.skin));
  out["hulls"] = pipeline::hullsJson(tree.hulls);
  out["levels"] = Json::array();
  const std::vector<Tightness> tightness = measureTightness(tree);
  for (std::size_t level = 0; level < tightness.size(); ++level) {
    const LevelStatistics& s = tree.statistics[level];
    const Tightness& t = tightness[level];
    Json line;
    line["level"] = level;
    line["nodes"] = tree.level_begin[level + 1] - tree.level_begin[level];
    line["inner_nodes"] = t.inner_nodes;
    line["spheres"] = s.sphere_count;
    line["overhang_bound_mm"] = s.overhang_bound == kUnproven ? Json(nullptr) : Json(s.overhang_bound);
    line["smallest_radius_mm"] = s.smallest_radius;
    line["largest_radius_mm"] = s.largest_radius;
    if (t.inner_nodes > 0)
      line["bounding_radius"] = {
          {"worst_over_smallest", t.worst_over_smallest}, {"mean_over_cover", t.mean_over_cover}, {"worst_over_cover", t.worst_over_cover}};
    out["levels"].push_back(line);
  }
  return out;
}

void printSkin(const Skin& skin) {
  if (skin.empty()) {
    printResult("skin        none\n");
    return;
  }
  const builder::SkinEvaluation s = builder::skinFigures(skin);
  constexpr double kDegree = 180 / std::numbers::pi;
  printResult("skin        %zu triangles, %zu of them flat, %zu sharp edges, %zu bytes\n", s.triangles, s.flat_triangles, s.sharp_edges,
              s.bytes);
  printResult("            flat triangles within %.3g mm of the mesh, patches within %.3g mm of them\n", s.mesh_distance, s.tolerance);
  printResult("            facets bend by %.3g, %.3g, %.3g degrees (median, p99, largest); sharp above %g\n", kDegree * s.edge_angle_median,
              kDegree * s.edge_angle_p99, kDegree * s.edge_angle_max, kDegree * s.crease_angle);
}

void printHulls(const Hulls& hulls) {
  if (!hulls.empty())
    printResult("hulls       %u in %zu parts of %zu balls, overhang bound %g mm\n", hulls.count, hulls.parts.size(), hulls.balls.size(),
                double{hulls.overhang_bound});
}

void printText(const SphereTree& tree, const std::filesystem::path& path, const FileFacts& file) {
  const Provenance& p = tree.provenance;
  printResult("%s: sound, %zu bytes, format %s\n", plainText(formats::shownName(path)).c_str(), file.bytes, file.version.c_str());
  printResult("made by     %s, builder %s, quality %s, seed %ju\n", p.generator.empty() ? "?" : plainText(p.generator).c_str(),
              p.builder.empty() ? "?" : plainText(p.builder).c_str(), p.quality.empty() ? "?" : plainText(p.quality).c_str(),
              static_cast<std::uintmax_t>(p.seed));
  if (p.tolerance_mm > 0) printResult("tolerance   %g mm\n", p.tolerance_mm);
  if (p.work_overhang_mm > 0)
    printResult("at work     leaves reach out at most %g mm, and farther only where their own tolerance allows it\n",
                static_cast<double>(p.work_overhang_mm));
  printResult("mesh        %ju triangles, diagonal %g mm, area %g mm^2, volume %g mm^3, unit %g mm\n",
              static_cast<std::uintmax_t>(p.triangle_count), p.diagonal_mm, p.area_mm2, p.volume_mm3, p.unit_mm);
  printResult("mesh hash   %s\nsettings    %s\n", toHex(p.mesh_hash).c_str(), toHex(p.settings_hash).c_str());
  printResult("origin      %g %g %g mm\n", tree.origin_mm[0], tree.origin_mm[1], tree.origin_mm[2]);
  printSkin(tree.skin);
  printHulls(tree.hulls);
  printResult("nodes       %zu, %zu of them inner, branching %d\n\n", tree.nodeCount(), tree.bound.size(), tree.branching);
  printResult("level  spheres  overhang bound [mm]  radii [mm]               bounding radius over smallest  over cover\n");
  const std::vector<Tightness> tightness = measureTightness(tree);
  for (std::size_t level = 0; level < tightness.size(); ++level) {
    const LevelStatistics& s = tree.statistics[level];
    const Tightness& t = tightness[level];
    char overhang[32] = "not proven", over_smallest[32] = "-", over_cover[32] = "-";
    if (s.overhang_bound != kUnproven) std::snprintf(overhang, sizeof overhang, "%g", static_cast<double>(s.overhang_bound));
    if (t.inner_nodes > 0) {
      std::snprintf(over_smallest, sizeof over_smallest, "%.5f", t.worst_over_smallest);
      std::snprintf(over_cover, sizeof over_cover, "%.3f to %.3f", t.mean_over_cover, t.worst_over_cover);
    }
    char radii[64];
    std::snprintf(radii, sizeof radii, "%g to %g", static_cast<double>(s.smallest_radius), static_cast<double>(s.largest_radius));
    printResult("%5zu  %7u  %19s  %-23s  %29s  %s\n", level, s.sphere_count, overhang, radii, over_smallest, over_cover);
  }
}

/// With --json, the error of a file without a sound tree is also part of the JSON.
void inspectOne(const std::filesystem::path& path, const InspectOptions& options, Json& list) {
  constexpr std::uint64_t kMaxBytes = 16 << 20;
  const std::vector<std::byte> bytes = formats::readFile(path, kMaxBytes);
  SphereTree tree;
  try {
    tree = formats::parseSphereTree(bytes, formats::shownName(path));
  } catch (const formats::FormatError& error) {
    list.push_back({{"schema", "spheretree.inspection/1"}, {"valid", false}, {"reason", error.what()}});
    if (options.trees.size() > 1) list.back()["file"] = path.string();
    throw;
  }
  if (!options.json) return printText(tree, path, factsOf(bytes));
  list.push_back(toJson(tree, factsOf(bytes)));
  if (options.trees.size() > 1) list.back()["file"] = path.string();
}

int runInspect(const InspectOptions& options) {
  Json list = Json::array();
  int code = kExitOk;
  for (const std::filesystem::path& path : options.trees) {
    if (!options.json && &path != &options.trees.front()) printResult("\n");
    try {
      inspectOne(path, options, list);
    } catch (const formats::FormatError& error) {  // the other files are still inspected
      code = explain(kProgram, kExitRefused, error.what());
    }
  }
  if (options.json) writeResult(jsonText(options.trees.size() > 1 ? list : list[0], 2) + "\n");
  return code;
}

}  // namespace

void addInspectCommand(Program& program) {
  const auto options = std::make_shared<InspectOptions>();
  CLI::App* app = addVerb(program, "inspect", "Show the content of a .stree file and prove that it is sound",
                          "spheretree inspect tooth.stree --json", [options](builder::Progress&) { return runInspect(*options); });
  app->add_option("TREE", options->trees, "Trees to inspect (.stree)")->required()->type_name("FILE...");
  app->add_flag("--json", options->json, "Print JSON on stdout; for a damaged file valid: false and the reason; for several trees a list");
}

}  // namespace spheretree::tool
