// SPDX-License-Identifier: GPL-3.0-or-later
#include "view/shown_stage.h"

#include <algorithm>
#include <memory>

#include "geometry/distance_field.h"
#include "model/cut_surface.h"
#include "model/moved_surface.h"
#include "molar.h"
#include "pipeline/mesh_store.h"
#include "pipeline/part_choice.h"
#include "probe.h"
#include "scene/cut_model.h"
#include "scene/tissue_model.h"
#include "spheretree/builder/mesh_checks.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/scene_file.h"
#include "view/start_pose.h"

namespace spheretree::player {
namespace {

/// Names and meshes: tool, then objects.
struct ShownItems {
  std::vector<std::string> names;
  std::vector<std::vector<std::string>> layers;  // that a burr cuts
  std::vector<TriangleMesh> meshes;              // a mesh without triangles is absent
  bool y_up = false;                             // all objects are from glTF, whose y axis points up, and stand as in their files
};

ShownItems itemsOf(const std::filesystem::path& path, std::vector<std::string>& notes) {
  ShownItems out;
  if (path.empty()) return {{"probe", "molar"}, {}, sampleMeshes()};
  const formats::SceneFile file = formats::readScene(path);
  pipeline::MeshStore files;
  const auto add = [&](const formats::SceneItem& item) {
    out.names.push_back(item.name);
    std::vector<std::string>& layers = out.layers.emplace_back();
    if (item.cut)
      for (const formats::CutLayer& layer : item.cut->layers) layers.push_back(layer.name);
    TriangleMesh& mesh = out.meshes.emplace_back();
    if (item.mesh.empty()) return;
    try {
      const auto read = files.read(file, path, item);
      mesh = item.part.empty() ? read->mesh.mesh : pipeline::partOf(read->mesh.mesh, item.part, read->components);
    } catch (const formats::FileError& error) {
      notes.push_back(item.name + " is shown by its spheres: " + error.what());
    } catch (const formats::FormatError& error) {
      notes.push_back(item.name + " is shown by its spheres: " + error.what());
    }
  };
  add(file.tool);
  for (const formats::SceneItem& object : file.objects) add(object);
  out.y_up = std::ranges::all_of(file.objects, [](const formats::SceneItem& object) {
    const std::string ending = object.mesh.extension().string();
    return (ending == ".glb" || ending == ".gltf") && isIdentity(object.pose);
  });
  return out;
}

/// The flat triangles of the skin of a tree.
TriangleMesh skinMesh(const SphereTree& tree) {
  TriangleMesh out;
  const Eigen::Vector3d origin(tree.origin_mm.data());
  for (const SkinVertex& v : tree.skin.vertices) out.positions.push_back(positionOf(tree.skin, v.position).cast<double>() + origin);
  for (const SkinTriangle& triangle : tree.skin.triangles)
    out.triangles.push_back({triangle.vertex[0], triangle.vertex[1], triangle.vertex[2]});
  return out;
}

/// `whole`: the mesh that is drawn.
std::shared_ptr<const view::CutMaterial> materialOf(const runtime::CutModel& model, const TriangleMesh& whole,
                                                    const std::vector<std::string>& names, view::Colour colour) {
  auto out = std::make_shared<view::CutMaterial>();
  const auto add = [&](const TriangleMesh& mesh) {
    const std::size_t k = out->layers.size();
    auto field = std::make_shared<const builder::DistanceField>(mesh);
    out->layers.push_back({names.at(k), view::layerColour(k, colour),
                           [field = std::move(field)](const Eigen::Vector3d& p) { return -field->signedDistance(p); }});
  };
  // Inside and outside need a sound mesh. The skin is one; it differs from the mesh by its tolerance.
  const bool is_sound = !whole.triangles.empty() && builder::checkMesh(whole).clean();
  add(is_sound ? whole : skinMesh(*model.tree));
  for (const runtime::CutLayer& layer : model.material.inner) add(*layer.surface);
  return out;
}

}  // namespace

std::vector<TriangleMesh> sampleMeshes() { return {samples::makeProbe(), samples::makeMolar()}; }

view::Stage stageOf(const runtime::SceneDescription& scene, const std::filesystem::path& path, std::vector<std::string>& notes) {
  const ShownItems items = itemsOf(path, notes);
  view::Stage stage;
  const auto add = [&](const SphereTree& tree, std::size_t i) {
    const TriangleMesh* mesh = items.meshes[i].triangles.empty() ? nullptr : &items.meshes[i];
    stage.bodies.push_back(view::bodyOf(items.names[i], &tree, mesh, view::colourOf(items.names[i], i)));
    readTooth(stage.bodies.back());
    return stage.bodies.size() - 1;
  };
  stage.tool = add(scene.tool, 0);
  stage.y_up = items.y_up;
  stage.reference_point = scene.reference_point;
  stage.burr = scene.burr;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    view::PlacedObject& object =
        stage.objects.emplace_back(view::PlacedObject{add(*scene.objects[i].tree, i + 1), scene.objects[i].pose, scene.objects[i].body});
    const view::Surface& mesh = stage.bodies[object.body].mesh;
    if (scene.objects[i].tissue && !mesh.empty())
      object.soft = std::make_shared<const view::MovedSurface>(mesh, scene.objects[i].tissue->tissue);
    if (scene.objects[i].cut && !scene.burr.empty())
      object.cut = materialOf(*scene.objects[i].cut, items.meshes[i + 1], items.layers[i + 1], stage.bodies[object.body].colour);
  }
  stage.force_limit = scene.wrench_limits.force;
  stage.torque_limit = scene.wrench_limits.torque;
  return stage;
}

}  // namespace spheretree::player
