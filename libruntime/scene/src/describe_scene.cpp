// SPDX-License-Identifier: Apache-2.0
#include "spheretree/scene/describe_scene.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/path_name.h"
#include "spheretree/formats/sphere_tree_file.h"
#include "spheretree/formats/trajectory.h"

namespace spheretree::scene {
namespace {

/// The trees of a scene; each is read and decoded once.
class Trees {
 public:
  const LoadedTree& at(const std::filesystem::path& file) {
    std::optional<LoadedTree>& of_file = of_file_[file];
    if (of_file) return *of_file;
    const std::vector<std::byte> bytes = formats::readFile(file, formats::kMaxSoftBytes);
    std::optional<LoadedTree>& of_bytes = of_bytes_[std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size())];
    if (!of_bytes) of_bytes = parseTree(bytes, formats::toUtf8(file));
    return *(of_file = of_bytes);
  }

 private:
  std::map<std::filesystem::path, std::optional<LoadedTree>> of_file_;
  std::map<std::string, std::optional<LoadedTree>> of_bytes_;
};

/// The flat triangles of the skin of a tree.
std::shared_ptr<const TriangleMesh> surfaceOf(const SphereTree& tree) {
  auto out = std::make_shared<TriangleMesh>();
  const Eigen::Vector3d origin(tree.origin_mm.data());
  for (const SkinVertex& v : tree.skin.vertices) out->positions.push_back(positionOf(tree.skin, v.position).cast<double>() + origin);
  for (const SkinTriangle& triangle : tree.skin.triangles)
    out->triangles.push_back({triangle.vertex[0], triangle.vertex[1], triangle.vertex[2]});
  return out;
}

std::shared_ptr<const runtime::CutModel> cutModelOf(const formats::SceneItem& object, const runtime::SharedTree& tree,
                                                    const std::filesystem::path& path, Trees& trees) {
  if (!object.cut) return nullptr;
  const std::vector<formats::CutLayer>& layers = object.cut->layers;
  runtime::CutMaterial material{layers.front().removal, {}, object.cut->tangential};
  for (std::size_t k = 1; k < layers.size(); ++k) {
    if (layers[k].tree.empty())
      throw formats::FormatError(path.string() + ": the layer " + layers[k].name + " of " + object.name +
                                 " has no tree. Build it: " + "spheretree batch " + path.string() + " -o DIR; then take DIR/scene.json.");
    material.inner.push_back({surfaceOf(*trees.at(formats::scenePath(path, layers[k].tree)).tree), layers[k].removal});
  }
  std::string fault;
  auto model = runtime::cutModel(tree, std::move(material), fault);
  if (!model) throw formats::FormatError(path.string() + ": cut of " + object.name + ": " + fault + ".");
  return model;
}

}  // namespace

LoadedTree parseTree(std::span<const std::byte> bytes, const std::string& name) {
  Tissue tissue;
  LoadedTree out{runtime::SharedTree::sound(formats::parseSoftTree(bytes, name, tissue)), nullptr};
  std::string fault;
  if (!tissue.empty()) out.tissue = runtime::tissueModel(out.tree, std::make_shared<const Tissue>(std::move(tissue)), fault);
  if (!fault.empty()) throw formats::FormatError(name + ": " + fault + ".");
  return out;
}

std::filesystem::path sceneFileAt(const std::filesystem::path& path) {
  std::error_code ignored;
  const std::filesystem::path inside = path / "scene.json";
  return std::filesystem::is_directory(path, ignored) && std::filesystem::exists(inside, ignored) ? inside : path;
}

runtime::SceneDescription describeScene(const formats::SceneFile& file, const std::filesystem::path& path,
                                        const std::function<void(double)>& on_tree) {
  if (!file.tool.reference_point.empty())
    throw formats::FormatError(formats::toUtf8(path) + ": tool.reference_point is for spheretree batch, which finds the point. Give " +
                               "reference_point_mm, or take the scene.json that batch writes.");
  Trees trees;
  std::size_t read = 0;
  const auto load = [&](const formats::SceneItem& item) -> const LoadedTree& {
    if (item.tree.empty())
      throw formats::FormatError(formats::toUtf8(path) + ": " + item.name + " names a mesh, and the runtime needs trees. Build them: " +
                                 "spheretree batch " + formats::toUtf8(path) + " -o DIR; then take DIR/scene.json.");
    if (on_tree) on_tree(static_cast<double>(++read) / static_cast<double>(file.objects.size() + 1));
    return trees.at(formats::scenePath(path, item.tree));
  };
  runtime::SceneDescription d;
  d.tool = *load(file.tool).tree;  // a tool is rigid
  d.reference_point = file.tool.reference_point_mm;
  d.tool_friction = file.tool.friction;
  d.burr = file.tool.burr;
  for (const formats::SceneItem& object : file.objects) {
    const LoadedTree& loaded = load(object);
    d.objects.push_back({loaded.tree, object.pose, bodyNumber(file, object.body), object.friction, object.stiffness_n_per_mm, loaded.tissue,
                         cutModelOf(object, loaded.tree, path, trees)});
  }
  d.coupling = {
      file.translation_n_per_mm, file.rotation_n_mm_per_rad, file.damping_n_s_per_mm, file.rotation_damping_n_mm_s_per_rad, file.mass_kg,
      file.inertia_kg_mm2};
  d.wrench_limits = {file.force_n, file.torque_n_mm};
  d.step_limits = runtime::defaultLimits(d.objects.size());
  return d;
}

std::uint32_t bodyNumber(const formats::SceneFile& scene, const std::string& name) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    if (scene.bodies[i].name == name) return static_cast<std::uint32_t>(i + 1);
  return 0;
}

Configuration BodyPath::at(double t) const noexcept {
  if (poses.empty()) return formats::hingePose(hinge, formats::hingeAngle(hinge, t));
  const double last = static_cast<double>(poses.size() - 1);
  return poses[static_cast<std::size_t>(std::clamp(std::round(1000 * t), 0.0, last))];
}

std::vector<BodyPath> readBodyPaths(const formats::SceneFile& file, const std::filesystem::path& path) {
  std::vector<BodyPath> paths;
  for (const formats::SceneBody& body : file.bodies) {
    if (body.hinge)
      paths.push_back({{}, *body.hinge});
    else
      paths.push_back({formats::readTrajectory(formats::scenePath(path, body.pose_csv)).poses, {}});
  }
  return paths;
}

}  // namespace spheretree::scene
