// SPDX-License-Identifier: GPL-3.0-or-later
#include "page/scene_view.h"

#include "page/model.h"
#include "pipeline/mesh_store.h"
#include "pipeline/sound_mesh.h"
#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/builder/provenance.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/mesh_file.h"
#include "spheretree/formats/sphere_tree_file.h"

namespace spheretree::tool {

std::string ModelStore::add(const std::string& name, const std::filesystem::path& tree_file, const ShownMesh* mesh) {
  Json& models = data_.root["models"];
  if (models.contains(name)) return name;
  const std::vector<std::byte> bytes = formats::readFile(tree_file);
  const auto [known, is_new] = name_of_.emplace(toHex(builder::bytesHash(bytes)), name);
  if (!is_new) return known->second;
  add(name, formats::parseSphereTree(bytes, tree_file.string()), mesh);
  return name;
}

void ModelStore::add(const std::string& name, const SphereTree& tree, const ShownMesh* mesh) {
  Json model = Json::object();
  if (mesh && !mesh->mesh.triangles.empty()) {
    const builder::SurfaceWithSheets surface = builder::surfaceWithSheets(mesh->mesh, mesh->to_cover);
    model["tree"] = packTree(data_, tree, &surface.field);
    model["mesh"] = packMesh(data_, mesh->mesh, surface, triangles_);
  } else {
    model["tree"] = packTree(data_, tree, nullptr);
  }
  data_.root["models"][name] = std::move(model);
}

ShownMeshes meshesOf(const std::filesystem::path& source_scene, builder::Progress& progress) {
  ShownMeshes out;
  pipeline::MeshStore files;
  ShownMeshes found;  // by file, part and repair
  try {
    const formats::SceneFile scene = formats::readScene(source_scene);
    const auto read = [&](const formats::SceneItem& item) {
      if (item.mesh.empty()) return;
      try {
        const auto file = files.read(scene, source_scene, item);
        const std::string repair = formats::mergedSettings(item.settings, scene.defaults).repair.value_or("auto");
        const std::string path = formats::scenePath(source_scene, item.mesh).string();
        std::shared_ptr<const ShownMesh>& shown = found[path + '\0' + item.unit + '\0' + item.part + '\0' + repair];
        if (!shown) {
          const TriangleMesh mesh = item.part.empty() ? file->mesh.mesh : pipeline::partOf(file->mesh.mesh, item.part, file->components);
          std::vector<std::string> notes;
          builder::RepairedMesh repaired = pipeline::soundMesh(mesh, path, pipeline::repairKind(repair), notes, progress);
          shown = std::make_shared<const ShownMesh>(ShownMesh{std::move(repaired.mesh), std::move(repaired.to_cover)});
        }
        out[item.name] = shown;
      } catch (const formats::FileError&) {  // removed since: shown without it
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

Json sceneForView(const formats::SceneFile& scene, const std::filesystem::path& file, const ShownMeshes& meshes, ModelStore& models) {
  const auto add = [&](const formats::SceneItem& item) {
    if (item.tree.empty())
      throw formats::FormatError(file.string() + ": " + item.name +
                                 " is a mesh; a page shows trees. Compile the scene with spheretree batch.");
    const auto mesh = meshes.find(item.name);
    return models.add(item.name, formats::scenePath(file, item.tree), mesh == meshes.end() ? nullptr : mesh->second.get());
  };
  const std::string tool = add(scene.tool);
  const Eigen::Vector3d& at = scene.tool.reference_point_mm;
  Json out{{"name", file.stem().string()},
           {"tool", {{"name", scene.tool.name}, {"model", tool}, {"reference_point_mm", {at.x(), at.y(), at.z()}}}},
           {"objects", Json::array()},
           {"replays", Json::array()}};
  for (const formats::SceneItem& object : scene.objects) {
    const std::string model = add(object);
    const Eigen::Vector3d& p = object.pose.position;
    const auto& q = object.pose.orientation;
    out["objects"].push_back({{"name", object.name},
                              {"model", model},
                              {"position_mm", {p.x(), p.y(), p.z()}},
                              {"quaternion_wxyz", {q.w(), q.x(), q.y(), q.z()}}});
  }
  return out;
}

}  // namespace spheretree::tool
