// SPDX-License-Identifier: Apache-2.0
#include "scene/describe_scene.h"

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/sphere_tree_file.h"

namespace spheretree::scene {
namespace {

struct Loaded {
  runtime::SharedTree tree;
  std::shared_ptr<const runtime::TissueModel> tissue;  // from a .soft file
};

Loaded parsed(const std::vector<std::byte>& bytes, const std::filesystem::path& file) {
  Tissue tissue;
  Loaded out{runtime::SharedTree::sound(formats::parseSoftTree(bytes, file.string(), tissue)), nullptr};
  std::string fault;
  if (!tissue.empty()) out.tissue = runtime::tissueModel(out.tree, std::make_shared<const Tissue>(std::move(tissue)), fault);
  if (!fault.empty()) throw formats::FormatError(file.string() + ": " + fault + ".");
  return out;
}

/// The trees of a scene; each is read and decoded once.
class Trees {
 public:
  const Loaded& at(const std::filesystem::path& file) {
    std::optional<Loaded>& of_file = of_file_[file];
    if (of_file) return *of_file;
    const std::vector<std::byte> bytes = formats::readFile(file, formats::kMaxSoftBytes);
    std::optional<Loaded>& of_bytes = of_bytes_[std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size())];
    if (!of_bytes) of_bytes = parsed(bytes, file);
    return *(of_file = of_bytes);
  }

 private:
  std::map<std::filesystem::path, std::optional<Loaded>> of_file_;
  std::map<std::string, std::optional<Loaded>> of_bytes_;
};

}  // namespace

runtime::SceneDescription describeScene(const formats::SceneFile& file, const std::filesystem::path& path,
                                        const std::function<void(double)>& on_tree) {
  if (!file.tool.reference_point.empty())
    throw formats::FormatError(path.string() + ": tool.reference_point is for spheretree batch, which finds the point. Give " +
                               "reference_point_mm, or take the scene.json that batch writes.");
  Trees trees;
  std::size_t read = 0;
  const auto load = [&](const formats::SceneItem& item) -> const Loaded& {
    if (item.tree.empty())
      throw formats::FormatError(path.string() + ": " + item.name + " names a mesh, and the runtime needs trees. Build them: " +
                                 "spheretree batch " + path.string() + " -o DIR; then take DIR/scene.json.");
    if (on_tree) on_tree(static_cast<double>(++read) / static_cast<double>(file.objects.size() + 1));
    return trees.at(formats::scenePath(path, item.tree));
  };
  runtime::SceneDescription d;
  d.tool = *load(file.tool).tree;  // a tool is rigid
  d.reference_point = file.tool.reference_point_mm;
  d.tool_friction = file.tool.friction;
  for (const formats::SceneItem& object : file.objects) {
    const Loaded& loaded = load(object);
    d.objects.push_back(
        {loaded.tree, object.pose, bodyNumber(file, object.body), object.friction, object.stiffness_n_per_mm, loaded.tissue});
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

}  // namespace spheretree::scene
