// SPDX-License-Identifier: Apache-2.0
#include "describe_scene.h"

#include <map>

#include "spheretree/formats/errors.h"
#include "spheretree/formats/scene_file.h"
#include "spheretree/formats/sphere_tree_file.h"

namespace spheretree::python {

runtime::SceneDescription describeScene(const std::filesystem::path& path) {
  const formats::SceneFile file = formats::readScene(path);
  std::map<std::filesystem::path, runtime::SharedTree> trees;  // objects of one file share it
  const auto tree = [&](const formats::SceneItem& item) {
    if (item.tree.empty())
      throw formats::FormatError(path.string() + ": " + item.name +
                                 " names a mesh, and the runtime needs trees. Build them: spheretree batch " + path.string() +
                                 " -o DIR, or spheretree.batch(); then load DIR/scene.json.");
    const std::filesystem::path tree_file = formats::scenePath(path, item.tree);
    const auto found = trees.find(tree_file);
    return found != trees.end() ? found->second : trees.emplace(tree_file, formats::readSphereTree(tree_file)).first->second;
  };
  if (!file.tool.reference_point.empty())
    throw formats::FormatError(path.string() +
                               ": tool.reference_point is for spheretree batch, which finds the point. Load the scene.json that " +
                               "it writes, or give reference_point_mm.");
  runtime::SceneDescription d;
  d.tool = *tree(file.tool);
  d.reference_point = file.tool.reference_point_mm;
  d.tool_friction = file.tool.friction;
  for (const formats::SceneItem& object : file.objects) {
    std::uint32_t body = 0;  // as the runtime counts them: the world is 0
    for (std::size_t i = 0; i < file.bodies.size(); ++i)
      if (file.bodies[i].name == object.body) body = static_cast<std::uint32_t>(i + 1);
    d.objects.push_back({tree(object), object.pose, body, object.friction, object.stiffness_n_per_mm});
  }
  d.coupling = {file.translation_n_per_mm, file.rotation_n_mm_per_rad, file.damping_n_s_per_mm, file.rotation_damping_n_mm_s_per_rad};
  d.wrench_limits = {file.force_n, file.torque_n_mm};
  d.step_limits = runtime::defaultLimits(d.objects.size());
  return d;
}

}  // namespace spheretree::python
