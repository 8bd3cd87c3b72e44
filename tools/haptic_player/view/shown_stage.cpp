// SPDX-License-Identifier: GPL-3.0-or-later
#include "view/shown_stage.h"

#include <algorithm>

#include "model/moved_surface.h"
#include "molar.h"
#include "pipeline/mesh_store.h"
#include "pipeline/part_choice.h"
#include "probe.h"
#include "scene/tissue_model.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/scene_file.h"
#include "view/start_pose.h"

namespace spheretree::player {
namespace {

/// Names and meshes: tool, then objects.
struct ShownItems {
  std::vector<std::string> names;
  std::vector<TriangleMesh> meshes;  // a mesh without triangles is absent
  bool y_up = false;                 // all objects are from glTF, whose y axis points up, and stand as in their files
};

ShownItems itemsOf(const std::filesystem::path& path, std::vector<std::string>& notes) {
  ShownItems out;
  if (path.empty()) return {{"probe", "molar"}, sampleMeshes()};
  const formats::SceneFile file = formats::readScene(path);
  pipeline::MeshStore files;
  const auto add = [&](const formats::SceneItem& item) {
    out.names.push_back(item.name);
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
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    view::PlacedObject& object =
        stage.objects.emplace_back(view::PlacedObject{add(*scene.objects[i].tree, i + 1), scene.objects[i].pose, scene.objects[i].body});
    const view::Surface& mesh = stage.bodies[object.body].mesh;
    if (scene.objects[i].tissue && !mesh.empty())
      object.soft = std::make_shared<const view::MovedSurface>(mesh, scene.objects[i].tissue->tissue);
  }
  stage.force_limit = scene.wrench_limits.force;
  stage.torque_limit = scene.wrench_limits.torque;
  return stage;
}

}  // namespace spheretree::player
