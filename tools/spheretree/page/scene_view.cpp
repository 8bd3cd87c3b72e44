// SPDX-License-Identifier: GPL-3.0-or-later
#include "page/scene_view.h"

#include "page/model.h"
#include "pipeline/batch/mesh_store.h"
#include "pipeline/sound_mesh.h"
#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/mesh_file.h"
#include "spheretree/formats/sphere_tree_file.h"

namespace spheretree::tool {

void ModelStore::add(const std::string& name, const std::filesystem::path& tree_file, const ShownMesh* mesh) {
  Json& models = data_.root["models"];
  if (models.contains(name)) return;
  const SphereTree tree = formats::readSphereTree(tree_file);
  Json model = Json::object();
  if (mesh && !mesh->mesh.triangles.empty()) {
    const builder::SurfaceWithSheets surface = builder::surfaceWithSheets(mesh->mesh, mesh->to_cover);
    model["tree"] = packTree(data_, tree, &surface.field);
    model["mesh"] = packMesh(data_, mesh->mesh, surface, triangles_);
  } else {
    model["tree"] = packTree(data_, tree, nullptr);
  }
  models[name] = std::move(model);
}

std::map<std::string, ShownMesh> meshesOf(const std::filesystem::path& source_scene, builder::Progress& progress) {
  std::map<std::string, ShownMesh> out;
  pipeline::MeshStore files;
  try {
    const formats::SceneFile scene = formats::readScene(source_scene);
    const auto read = [&](const formats::SceneItem& item) {
      if (item.mesh.empty()) return;
      try {
        const std::filesystem::path path = formats::scenePath(source_scene, item.mesh);
        const auto file = files.read(path, formats::unitInMm(scene.unit));
        std::vector<std::string> notes;
        const formats::TreeSettings settings = formats::mergedSettings(item.settings, scene.defaults);
        const TriangleMesh mesh = item.part.empty() ? file->mesh.mesh : formats::selectPart(file->mesh.mesh, item.part);
        builder::RepairedMesh repaired =
            pipeline::soundMesh(mesh, path.string(), pipeline::repairKind(settings.repair.value_or("auto")), notes, progress);
        out[item.name] = {std::move(repaired.mesh), std::move(repaired.to_cover)};
      } catch (const formats::FileError&) {  // gone since: shown without it
      } catch (const formats::FormatError&) {
      } catch (const builder::BuildError&) {
      }
    };
    read(scene.tool);
    for (const formats::SceneItem& object : scene.objects) read(object);
  } catch (const formats::FileError&) {
  } catch (const formats::FormatError&) {
  }
  return out;
}

Json sceneForView(const formats::SceneFile& scene, const std::filesystem::path& file, const std::map<std::string, ShownMesh>& meshes,
                  ModelStore& models) {
  const auto add = [&](const formats::SceneItem& item) {
    if (item.tree.empty())
      throw formats::FormatError(file.string() + ": " + item.name +
                                 " is a mesh; a page shows trees. Compile the scene with spheretree batch.");
    const auto mesh = meshes.find(item.name);
    models.add(item.name, formats::scenePath(file, item.tree), mesh == meshes.end() ? nullptr : &mesh->second);
  };
  add(scene.tool);
  const Eigen::Vector3d& at = scene.tool.reference_point_mm;
  Json out{{"name", file.stem().string()},
           {"tool", {{"name", scene.tool.name}, {"model", scene.tool.name}, {"reference_point_mm", {at.x(), at.y(), at.z()}}}},
           {"objects", Json::array()},
           {"replays", Json::array()}};
  for (const formats::SceneItem& object : scene.objects) {
    add(object);
    const Eigen::Vector3d& p = object.pose.position;
    const auto& q = object.pose.orientation;
    out["objects"].push_back({{"name", object.name},
                              {"model", object.name},
                              {"position_mm", {p.x(), p.y(), p.z()}},
                              {"quaternion_wxyz", {q.w(), q.x(), q.y(), q.z()}}});
  }
  return out;
}

}  // namespace spheretree::tool
