// SPDX-License-Identifier: GPL-3.0-or-later
#include "view/shown_files.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "geometry/distance_field.h"
#include "input/tree_input.h"
#include "pipeline/comparison/comparison_json.h"
#include "pipeline/mesh_store.h"
#include "pipeline/part_choice.h"
#include "program_end.h"
#include "run_files.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/mesh_file.h"
#include "spheretree/formats/scene_file.h"

namespace spheretree::tool {
namespace {

namespace fs = std::filesystem;
using Files = std::vector<std::unique_ptr<ShownFile>>;

/// A mesh with the distance field for the overhang of balls.
struct KnownMesh {
  fs::path path;
  TriangleMesh mesh;
  builder::DistanceField field;
  bool is_compared = false;  // known to be the mesh of the trees
};

std::string number(const char* format, double value) {
  char text[48];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

constexpr int kMaxTriangles = 200'000;  // for the balls of a level, coloured by their overhang

/// The ball with the largest overhang over the mesh, and its place.
std::optional<view::Spot> worstOf(const std::vector<view::Ball>& balls, const builder::DistanceField& field) {
  std::optional<view::Spot> worst;
  for (const view::Ball& ball : balls) {
    const Eigen::Vector3d centre(ball.x, ball.y, ball.z);
    builder::NearestPoint nearest;
    const double overhang = static_cast<double>(ball.radius) + field.signedDistance(centre, &nearest);
    if (worst && overhang <= worst->length) continue;
    const Eigen::Vector3d way = nearest.point - centre, outward = field.isInside(centre, nearest) ? way : Eigen::Vector3d(-way);
    const Eigen::Vector3d direction = outward.norm() > 1e-9 ? outward.normalized() : Eigen::Vector3d::UnitZ();
    worst = view::Spot{centre + static_cast<double>(ball.radius) * direction, direction, std::max(0.0, overhang)};
  }
  return worst;
}

/// Adds the balls of each level, with their local overhang over the mesh; colourOverhangs() colours them.
void addOverhangs(view::Body& body, const builder::DistanceField& field, std::vector<std::vector<double>>& outside_of_level,
                  builder::Progress& progress) {
  for (const std::vector<view::Ball>& level : body.levels) {
    int rounds = 1;
    while (rounds < 5 && static_cast<double>(level.size()) * 20 * std::pow(4, rounds + 1) <= kMaxTriangles) ++rounds;
    view::TintedSurface& tinted = body.overhangs.emplace_back();
    for (const view::Ball& ball : level) view::addBall(tinted.surface, {ball.x, ball.y, ball.z}, static_cast<double>(ball.radius), rounds);
    std::vector<double>& outside = outside_of_level.emplace_back();
    double largest = 0;
    for (const view::SurfaceCorner& corner : tinted.surface.corners) {
      if (outside.size() % 4096 == 0) progress.check();
      outside.push_back(std::max(0.0, field.signedDistance(corner.position.cast<double>())));
      largest = std::max(largest, outside.back());
    }
    body.overhang_max.push_back(largest);
    body.worst.push_back(worstOf(level, field));
  }
}

/// Colours the overhang of each level, with one scale for all files.
void colourOverhangs(Files& files) {
  for (std::size_t level = 0, levels = 1; level < levels; ++level) {
    double largest = 0;
    for (const auto& file : files) {
      levels = std::max(levels, file->outside.size());
      if (level < file->outside.size()) largest = std::max(largest, file->stage.bodies[0].overhang_max[level]);
    }
    for (const auto& file : files) {
      if (level >= file->outside.size()) continue;
      view::Body& body = file->stage.bodies[0];
      body.overhang_max[level] = largest;
      for (const double distance : file->outside[level])
        body.overhangs[level].colours.push_back(view::heat(largest > 0 ? distance / largest : 0));
    }
  }
}

void addMeshFigures(ShownFile& shown, const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : mesh.positions) box.extend(p);
  shown.figures.push_back({"triangles", std::to_string(mesh.triangles.size())});
  const Eigen::Vector3d size = box.sizes();
  shown.figures.push_back({"size", number("%.4g", size.x()) + " x " + number("%.4g", size.y()) + " x " + number("%.4g mm", size.z())});
}

void addTreeFigures(ShownFile& shown, const SphereTree& tree) {
  for (int level = 0; level < tree.levelCount(); ++level) {
    const LevelStatistics& s = tree.statistics[static_cast<std::size_t>(level)];
    const std::string bound = s.overhang_bound >= 0 ? number("%.4g mm", static_cast<double>(s.overhang_bound)) : "no bound";
    shown.figures.push_back({"level " + std::to_string(level) + ": " + std::to_string(s.sphere_count) + " spheres", bound});
  }
  if (!tree.skin.empty()) shown.figures.push_back({"skin", std::to_string(tree.skin.triangles.size()) + " triangles"});
}

std::unique_ptr<ShownFile> shownMesh(const KnownMesh& mesh) {
  auto shown = std::make_unique<ShownFile>();
  shown->title = mesh.path.filename().string();
  shown->stage.bodies.push_back(view::bodyOf(shown->title, nullptr, &mesh.mesh, view::colourOf(shown->title, 0)));
  shown->stage.objects = {{0, {}}};
  addMeshFigures(*shown, mesh.mesh);
  return shown;
}

std::unique_ptr<ShownFile> shownTree(const fs::path& path, const KnownMesh* mesh, builder::Progress& progress) {
  const SphereTree tree = readTree(path);
  auto shown = std::make_unique<ShownFile>();
  shown->title = path.filename().string();
  view::Body body = view::bodyOf(shown->title, &tree, mesh ? &mesh->mesh : nullptr, view::colourOf(shown->title, 0));
  addTreeFigures(*shown, tree);
  if (mesh) {
    addOverhangs(body, mesh->field, shown->outside, progress);
    addMeshFigures(*shown, mesh->mesh);
    if (const std::string warning = otherMeshWarning(tree, path, mesh->mesh, mesh->path); !mesh->is_compared && !warning.empty())
      shown->notes.push_back(warning);
  }
  shown->stage.bodies.push_back(std::move(body));
  shown->stage.objects = {{0, {}}};
  return shown;
}

std::unique_ptr<ShownFile> shownScene(const fs::path& path, builder::Progress& progress) {
  const formats::SceneFile scene = formats::readScene(path);
  auto shown = std::make_unique<ShownFile>();
  shown->title = path.filename().string();
  pipeline::MeshStore meshes;
  for (const formats::SceneItem& item : scene.objects) {
    progress.check();
    std::optional<SphereTree> tree;
    if (!item.tree.empty()) tree = readTree(formats::scenePath(path, item.tree));
    TriangleMesh mesh;
    if (!item.mesh.empty()) try {
        const auto file = meshes.read(scene, path, item);
        mesh = item.part.empty() ? file->mesh.mesh : pipeline::partOf(file->mesh.mesh, item.part, file->components);
      } catch (const formats::FileError& error) {
        if (!tree) throw;
        shown->notes.push_back(item.name + " is shown by its spheres: " + error.what());
      }
    const std::size_t index = shown->stage.bodies.size();
    shown->stage.bodies.push_back(
        view::bodyOf(item.name, tree ? &*tree : nullptr, mesh.triangles.empty() ? nullptr : &mesh, view::colourOf(item.name, index)));
    shown->stage.objects.push_back({index, item.pose});
  }
  std::size_t leaves = 0;
  for (const view::Body& body : shown->stage.bodies) leaves += body.levels.empty() ? 0 : body.levels.back().size();
  shown->figures = {{"objects", std::to_string(scene.objects.size())}, {"leaves", std::to_string(leaves)}};
  return shown;
}

void addComparison(Files& out, const fs::path& path, const std::string& wanted, builder::Progress& progress) {
  const pipeline::Comparison comparison = pipeline::readComparison(path);
  if (comparison.meshes.empty()) throw formats::FormatError(path.string() + ": compares no mesh");
  const auto figures = std::find_if(comparison.meshes.begin(), comparison.meshes.end(),
                                    [&](const pipeline::MeshFigures& m) { return wanted.empty() || m.name == wanted; });
  if (figures == comparison.meshes.end()) {
    std::string names;
    for (const pipeline::MeshFigures& m : comparison.meshes) names += (names.empty() ? "" : ", ") + m.name;
    throw UsageError("--mesh " + wanted + ": the comparison has " + names);
  }
  KnownMesh mesh{figures->file, formats::readMesh(figures->file, figures->unit_mm).mesh, {}};
  mesh.field = builder::DistanceField(mesh.mesh);
  mesh.is_compared = true;
  std::vector<const pipeline::Run*> runs;
  for (const pipeline::Run& run : comparison.runs)
    if (run.mesh == figures->name && run.isBuilt()) runs.push_back(&run);
  const auto overhang = [](const pipeline::Run* run) { return run->levels.empty() ? 0 : run->levels.back().overhang.max; };
  std::stable_sort(runs.begin(), runs.end(), [&](const pipeline::Run* a, const pipeline::Run* b) { return overhang(a) < overhang(b); });
  std::vector<const pipeline::Run*> best;  // of each builder, without the search where there is one
  for (const bool search : {false, true})
    for (const pipeline::Run* run : runs) {
      const auto isOfIt = [&](const pipeline::Run* other) { return other->method.builder.kind == run->method.builder.kind; };
      if (run->method.builder.search == search && std::ranges::none_of(best, isOfIt)) best.push_back(run);
    }
  runs = std::move(best);
  std::stable_sort(runs.begin(), runs.end(), [&](const pipeline::Run* a, const pipeline::Run* b) { return overhang(a) < overhang(b); });
  runs.resize(std::min(runs.size(), kMaxPanes - std::min(kMaxPanes, out.size())));
  for (const pipeline::Run* run : runs) {
    out.push_back(shownTree(path.parent_path() / run->tree, &mesh, progress));
    out.back()->title = idOf(run->method) + number(": %.4g mm", overhang(run));
  }
}

bool isComparison(const fs::path& path) { return path.filename() == "compare.json"; }

/// What a folder of compare, batch or split is shown by.
fs::path fileIn(const fs::path& folder) {
  for (const char* name : {"compare.json", "scene.json", "mouth.scene.json"})
    if (fs::exists(folder / name)) return folder / name;
  throw formats::FileError(folder.string() +
                           ": neither compare.json nor scene.json nor mouth.scene.json is in this folder. Name the folder that compare, "
                           "batch or split wrote, or files in it.");
}

/// A scene names its schema; a tree as JSON has a different one.
bool isScene(const fs::path& path) {
  if (endingOf(path) != ".json") return false;
  try {
    (void)formats::readScene(path);
    return true;
  } catch (const formats::FormatError&) {
    return path.string().ends_with("scene.json");  // intended as a scene: its error is reported
  }
}

}  // namespace

Files shownFiles(const std::vector<fs::path>& files, const std::string& mesh_name, double unit_mm, builder::Progress& progress) {
  Files out;
  std::optional<KnownMesh> mesh;
  bool mesh_stands_alone = false;
  const auto showMesh = [&] {
    if (mesh && mesh_stands_alone) out.push_back(shownMesh(*mesh));
    mesh_stands_alone = false;
  };
  for (fs::path path : files) {
    progress.check();
    if (fs::is_directory(path)) path = fileIn(path);
    const std::string ending = endingOf(path);
    if (isComparison(path)) {
      addComparison(out, path, mesh_name, progress);
    } else if (isScene(path)) {
      out.push_back(shownScene(path, progress));
    } else if (ending == ".stree" || ending == ".sph" || ending == ".json") {
      out.push_back(shownTree(path, mesh ? &*mesh : nullptr, progress));
      mesh_stands_alone = false;
    } else {
      showMesh();
      mesh = KnownMesh{path, formats::readMesh(path, unit_mm).mesh, {}};
      mesh->field = builder::DistanceField(mesh->mesh);
      mesh_stands_alone = true;
    }
  }
  showMesh();
  if (out.size() > kMaxPanes)
    throw UsageError(std::to_string(out.size()) + " things to show; a window has room for " + std::to_string(kMaxPanes));
  colourOverhangs(out);
  return out;
}

}  // namespace spheretree::tool
