// SPDX-License-Identifier: GPL-3.0-or-later
#include "view/shown_files.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "geometry/distance_field.h"
#include "input/tree_input.h"
#include "pipeline/comparison/comparison_json.h"
#include "pipeline/mesh_store.h"
#include "pipeline/part_choice.h"
#include "program_end.h"
#include "robot/files/robot_files.h"
#include "robot/files/sphere_file.h"
#include "run_files.h"
#include "spheretree/core/mesh_edit.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/mesh_file.h"
#include "spheretree/formats/scene_file.h"
#include "terminal.h"

namespace spheretree::tool {
namespace {

namespace fs = std::filesystem;
using Files = std::vector<std::unique_ptr<ShownFile>>;

/// The solids that balls are measured against; together they are one object.
struct Solids {
  std::vector<builder::DistanceField> fields;

  struct Nearest {
    double distance;  // signed [mm]
    builder::NearestPoint point;
    const builder::DistanceField* field;
  };
  /// The nearest place of a solid that the point is deepest in, or least far from.
  Nearest nearest(const Eigen::Vector3d& p) const {
    Nearest out{std::numeric_limits<double>::infinity(), {}, nullptr};
    for (const builder::DistanceField& field : fields) {
      builder::NearestPoint point;
      if (const double distance = field.signedDistance(p, &point); distance < out.distance) out = {distance, point, &field};
    }
    return out;
  }
};

struct KnownMesh {
  fs::path path;
  formats::MeshFile file;
  Solids solids;
  bool is_compared = false;  // known to be the mesh of the trees
  const TriangleMesh& mesh() const { return file.mesh; }
};

std::string number(const char* format, double value) {
  char text[48];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

constexpr double kMaxTriangles = 200'000;  // for the balls of a level of all bodies, coloured by their overhang

/// The ball with the largest overhang over the mesh, and its place.
std::optional<view::Spot> worstOf(const std::vector<view::Ball>& balls, const Solids& solids) {
  std::optional<view::Spot> worst;
  for (const view::Ball& ball : balls) {
    const Eigen::Vector3d centre(ball.x, ball.y, ball.z);
    const Solids::Nearest nearest = solids.nearest(centre);
    const double overhang = static_cast<double>(ball.radius) + nearest.distance;
    if (worst && overhang <= worst->length) continue;
    const Eigen::Vector3d way = nearest.point.point - centre;
    const Eigen::Vector3d outward = nearest.field->isInside(centre, nearest.point) ? way : Eigen::Vector3d(-way);
    const Eigen::Vector3d direction = outward.norm() > 1e-9 ? outward.normalized() : Eigen::Vector3d::UnitZ();
    worst = view::Spot{centre + static_cast<double>(ball.radius) * direction, direction, std::max(0.0, overhang)};
  }
  return worst;
}

/// Adds the balls of each level, with their local overhang over the mesh; colourOverhangs() colours them. Returns the
/// overhang at each corner of the balls of each level.
std::vector<std::vector<double>> addOverhangs(view::Body& body, const Solids& solids, double max_triangles, builder::Progress& progress) {
  std::vector<std::vector<double>> outside_of_level;
  for (const std::vector<view::Ball>& level : body.levels) {
    int rounds = 1;
    while (rounds < 5 && static_cast<double>(level.size()) * 20 * std::pow(4, rounds + 1) <= max_triangles) ++rounds;
    view::TintedSurface& tinted = body.overhangs.emplace_back();
    for (const view::Ball& ball : level) view::addBall(tinted.surface, {ball.x, ball.y, ball.z}, static_cast<double>(ball.radius), rounds);
    std::vector<double>& outside = outside_of_level.emplace_back();
    double largest = 0;
    for (const view::SurfaceCorner& corner : tinted.surface.corners) {
      if (outside.size() % 4096 == 0) progress.check();
      outside.push_back(std::max(0.0, solids.nearest(corner.position.cast<double>()).distance));
      largest = std::max(largest, outside.back());
    }
    body.overhang_max.push_back(largest);
    body.worst.push_back(worstOf(level, solids));
  }
  return outside_of_level;
}

/// Colours the overhang of each level, with one scale for all files.
void colourOverhangs(Files& files) {
  for (std::size_t level = 0, levels = 1; level < levels; ++level) {
    double largest = 0;
    std::vector<std::pair<view::Body*, const std::vector<double>*>> coloured;
    for (const auto& file : files)
      for (std::size_t b = 0; b < file->outside.size(); ++b) {
        levels = std::max(levels, file->outside[b].size());
        if (level >= file->outside[b].size()) continue;
        coloured.emplace_back(&file->stage.bodies[b], &file->outside[b][level]);
        largest = std::max(largest, coloured.back().first->overhang_max[level]);
      }
    for (const auto& [body, outside] : coloured) {
      body->overhang_max[level] = largest;
      for (const double distance : *outside) body->overhangs[level].colours.push_back(view::heat(largest > 0 ? distance / largest : 0));
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
    shown.figures.push_back({"level " + std::to_string(level) + ": " + counted(s.sphere_count, "sphere"), bound});
  }
  if (!tree.skin.empty()) shown.figures.push_back({"skin", std::to_string(tree.skin.triangles.size()) + " triangles"});
}

view::Colour asColour(const std::array<std::uint8_t, 3>& c) { return {c[0], c[1], c[2], 255}; }

/// A body for each colour of each part of the mesh, in the order of their first triangles.
std::vector<view::Body> colouredBodies(const formats::MeshFile& file) {
  const TriangleMesh& mesh = file.mesh;
  std::map<std::pair<std::uint32_t, std::array<std::uint8_t, 3>>, std::size_t> index;
  std::vector<TriangleMesh> pieces;
  std::vector<view::Body> bodies;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t part = mesh.part.empty() ? 0 : mesh.part[t];
    const auto [at, is_new] = index.try_emplace({part, file.colours[t]}, pieces.size());
    if (is_new) {
      pieces.emplace_back().positions = mesh.positions;
      bodies.emplace_back().name = mesh.part.empty() ? "mesh" : mesh.part_names[part];
    }
    pieces[at->second].triangles.push_back(mesh.triangles[t]);
  }
  for (const auto& [key, at] : index) {
    dropUnusedVertices(pieces[at]);
    bodies[at] = view::bodyOf(bodies[at].name, nullptr, &pieces[at], asColour(key.second));
  }
  return bodies;
}

std::unique_ptr<ShownFile> shownMesh(const KnownMesh& mesh) {
  auto shown = std::make_unique<ShownFile>();
  shown->title = mesh.path.filename().string();
  if (mesh.file.colours.empty())
    shown->stage.bodies.push_back(view::bodyOf(shown->title, nullptr, &mesh.mesh(), view::colourOf(shown->title, 0)));
  else
    shown->stage.bodies = colouredBodies(mesh.file);
  for (std::size_t b = 0; b < shown->stage.bodies.size(); ++b) shown->stage.objects.push_back({b, {}});
  addMeshFigures(*shown, mesh.mesh());
  return shown;
}

/// The triangles that belong to one tetrahedron only, turned outward.
TriangleMesh boundaryOf(const Tissue& tissue) {
  std::map<std::array<std::uint32_t, 3>, std::pair<int, Triangle>> faces;  // by its sorted corners
  for (const auto& [a, b, c, d] : tissue.tetrahedra)
    for (const Triangle& face : {Triangle{a, c, b}, Triangle{a, b, d}, Triangle{a, d, c}, Triangle{b, c, d}}) {
      std::array<std::uint32_t, 3> key = face;
      std::sort(key.begin(), key.end());
      const auto at = faces.try_emplace(key, 0, face).first;
      ++at->second.first;
    }
  TriangleMesh mesh;
  for (const auto& node : tissue.nodes) mesh.positions.emplace_back(node.data());
  for (const auto& [key, face] : faces)
    if (face.first == 1) mesh.triangles.push_back(face.second);
  dropUnusedVertices(mesh);
  return mesh;
}

constexpr double kFlat = 1e-3;  // [rad] no edge is smooth, so that each tetrahedron is seen

/// `mesh`: of the tree, or null; a soft tree without it is shown with the surface of its tetrahedra.
std::unique_ptr<ShownFile> shownTree(const fs::path& path, const KnownMesh* mesh, builder::Progress& progress) {
  auto shown = std::make_unique<ShownFile>();
  shown->title = path.filename().string();
  Tissue tissue;
  const bool is_soft = endingOf(path) == ".soft";
  const SphereTree tree = is_soft                     ? readSoftTree(path, tissue)
                          : robot::isSphereFile(path) ? robot::levelOf(robot::setOf(robot::readSphereFile(path), path, ""))
                                                      : readTree(path);
  view::Body body = view::bodyOf(shown->title, &tree, mesh ? &mesh->mesh() : nullptr, view::colourOf(shown->title, 0));
  addTreeFigures(*shown, tree);
  if (is_soft) {
    shown->figures.push_back({"tetrahedra", std::to_string(tissue.tetrahedra.size())});
    shown->figures.push_back({"nodes, held", std::to_string(tissue.nodes.size()) + ", " + std::to_string(tissue.fixed.size())});
    shown->figures.push_back({"Young's modulus", number("%.4g kPa", tissue.material.young_kpa)});
    if (!mesh) {
      const TriangleMesh boundary = boundaryOf(tissue);
      body.mesh = view::surfaceOf(boundary, kFlat);
      for (const Eigen::Vector3d& p : boundary.positions) body.box.extend(p);
    }
  }
  if (mesh) {
    shown->outside.push_back(addOverhangs(body, mesh->solids, kMaxTriangles, progress));
    addMeshFigures(*shown, mesh->mesh());
    if (const std::string warning = otherMeshWarning(tree, path, mesh->mesh(), mesh->path); !mesh->is_compared && !warning.empty())
      shown->notes.push_back(warning);
  }
  shown->stage.bodies.push_back(std::move(body));
  shown->stage.objects = {{0, {}}};
  return shown;
}

/// A robot, and its spheres if a file of them is given.
std::unique_ptr<ShownFile> shownRobot(const robot::RobotInput& input, const fs::path& spheres, builder::Progress& progress) {
  const auto [robot, shapes] = robot::readRobot(input, progress);
  const std::vector<std::span<const robot::ShapedElement>> links = robot::linksOf(shapes);
  const std::vector<Eigen::Isometry3d> pose = robot::zeroPose(robot);
  std::optional<robot::SphereFile> file;
  if (!spheres.empty()) file = robot::readSphereFile(spheres);
  auto shown = std::make_unique<ShownFile>();
  shown->title = robot.name + (file ? ", " + spheres.filename().string() : "");
  shown->notes = robot.notes;
  std::size_t count = 0;
  std::vector<std::string> bare;
  for (const auto elements : links) {
    progress.check();
    const std::size_t l = elements.front().link;
    const std::string& name = robot.links[l].name;
    const TriangleMesh mesh = robot::meshOf(elements);
    const std::size_t index = shown->stage.bodies.size();
    const auto set = file ? std::find_if(file->sets.begin(), file->sets.end(), [&](const auto& s) { return s.link == name; })
                          : std::vector<robot::SphereSet>::const_iterator();
    const bool has_spheres = file && set != file->sets.end();
    const SphereTree level = has_spheres ? robot::levelOf(*set) : SphereTree();
    view::Body body = view::bodyOf(name, has_spheres ? &level : nullptr, &mesh, view::colourOf(name, index));
    if (has_spheres) {
      Solids solids;
      for (const robot::ShapedElement& element : elements) solids.fields.emplace_back(robot::meshOf(std::span(&element, 1)));
      shown->outside.resize(index + 1);
      shown->outside[index] = addOverhangs(body, solids, kMaxTriangles / static_cast<double>(links.size()), progress);
      count += set->balls.size();
    } else if (file) {
      bare.push_back(name);
    }
    shown->stage.bodies.push_back(std::move(body));
    shown->stage.objects.push_back({index, {pose[l].translation(), Eigen::Quaterniond(pose[l].linear())}});
  }
  if (file && count == 0)
    throw formats::FormatError(spheres.string() + ": has no spheres of a link of " + input.urdf.string() +
                               ". Name the spheres of this robot.");
  for (const std::string& name : bare) shown->notes.push_back(name + " has no spheres.");
  shown->figures = {{"links with shapes", std::to_string(links.size())}};
  if (file) shown->figures.push_back({"spheres", std::to_string(count)});
  shown->opens_on_spheres = file.has_value();
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
  KnownMesh mesh{figures->file, formats::readMesh(figures->file, figures->unit_mm), {}, true};
  mesh.solids.fields.emplace_back(mesh.mesh());
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
    out.back()->opens_on_overhang = true;
  }
}

bool isComparison(const fs::path& path) { return path.filename() == "compare.json"; }

/// What a folder of compare, batch, split or robot is shown by.
fs::path fileIn(const fs::path& folder) {
  for (const char* name : {"compare.json", "scene.json", "mouth.scene.json", robot::kManifestName})
    if (fs::exists(folder / name)) return folder / name;
  throw formats::FileError(folder.string() +
                           ": neither compare.json nor scene.json nor mouth.scene.json nor robot.json is in this folder. Name the folder "
                           "that compare, batch, split or robot wrote, or files in it.");
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

Files shownFiles(const ShownRequest& request, builder::Progress& progress) {
  Files out;
  // What the next trees or spheres belong to: a mesh, a robot or nothing.
  std::optional<KnownMesh> mesh;
  std::optional<robot::RobotInput> robot;
  bool stands_alone = false;  // it has not been shown yet
  const auto showAlone = [&] {
    if (stands_alone) out.push_back(robot ? shownRobot(*robot, {}, progress) : shownMesh(*mesh));
    stands_alone = false;
  };
  for (fs::path path : request.files) {
    progress.check();
    if (fs::is_directory(path)) path = fileIn(path);
    const std::string ending = endingOf(path);
    if (isComparison(path)) {
      addComparison(out, path, request.mesh, progress);
    } else if (path.filename() == robot::kManifestName) {
      const robot::RobotManifest manifest = robot::readManifest(path);
      out.push_back(shownRobot(manifest.input, manifest.spheres, progress));
    } else if (ending == ".urdf") {
      showAlone();
      robot = request.robot;
      robot->urdf = path;
      if (!request.unit.empty()) robot->units = {request.unit};
      stands_alone = true;
    } else if (isScene(path)) {
      out.push_back(shownScene(path, progress));
    } else if (robot && robot::isSphereFile(path)) {
      out.push_back(shownRobot(*robot, path, progress));
      stands_alone = false;
    } else if (ending == ".stree" || ending == ".soft" || ending == ".sph" || ending == ".json" || robot::isSphereFile(path)) {
      out.push_back(shownTree(path, mesh && !robot ? &*mesh : nullptr, progress));
      stands_alone = stands_alone && robot;
    } else {
      showAlone();
      robot.reset();
      mesh = KnownMesh{path, formats::readMesh(path, formats::unitInMm(request.unit)), {}, false};
      mesh->solids.fields.emplace_back(mesh->mesh());
      stands_alone = true;
    }
  }
  showAlone();
  if (out.size() > kMaxPanes)
    throw UsageError(std::to_string(out.size()) + " things to show; a window has room for " + std::to_string(kMaxPanes));
  colourOverhangs(out);
  return out;
}

}  // namespace spheretree::tool
