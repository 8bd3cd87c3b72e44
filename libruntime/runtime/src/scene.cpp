// SPDX-License-Identifier: Apache-2.0
#include "spheretree/runtime/scene.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "block.h"
#include "search_tree.h"

namespace spheretree::runtime {
namespace {

bool inRange(double value, double low, double high) { return value >= low && value <= high; }

// Leaves in file order, and the tree over them that the search follows, in the frame of the file.
struct Leaves {
  std::vector<std::uint32_t> node;
  std::vector<SearchNode> tree;
  Eigen::Vector3d origin;  // of the file's frame in the mesh's

  explicit Leaves(const SphereTree& file) : node(levelSet(file, file.levelCount() - 1)), origin(file.origin_mm.data()) {
    std::vector<Sphere> spheres;
    for (const std::uint32_t n : node) spheres.push_back(file.cover[n]);
    tree = makeSearchTree(spheres);
  }
  Eigen::Vector3d centre(const SearchNode& n) const { return Eigen::Vector3d(n.sphere.x, n.sphere.y, n.sphere.z) + origin; }
  /// The leaves alone, about a point of the mesh's frame.
  std::vector<Sphere> about(const Eigen::Vector3d& point) const {
    std::vector<Sphere> out;
    for (const SearchNode& n : tree) {
      if (n.leaf == kNotALeaf) continue;
      const Eigen::Vector3f c = (centre(n) - point).cast<float>();
      out.push_back({c.x(), c.y(), c.z(), n.sphere.radius});
    }
    return out;
  }
};

// `place` maps a centre of the tree's mesh frame to the frame of the compiled tree.
template <class Place>
CompiledTree compileTree(const Leaves& leaves, const Place& place) {
  CompiledTree out;
  const std::size_t blocks = 1 + leaves.tree.size() - leaves.node.size();
  out.bound.assign(blocks, emptyBlock());
  out.spheres.assign(8 * blocks, Sphere{kFarAway, kFarAway, kFarAway, 0});
  out.links.assign(blocks, {});
  out.exact.assign(8 * blocks, {kFarAway, kFarAway, kFarAway});
  out.node.assign(8 * blocks, kNoNode);
  out.smallest_radius = std::numeric_limits<float>::infinity();

  std::uint16_t next_block = 1;
  const auto putNode = [&](std::size_t slot, const SearchNode& n) {
    const Eigen::Vector3d c = place(leaves.centre(n));
    put(out.bound[slot / 8], slot % 8, c, n.sphere.radius);
    out.spheres[slot] = {static_cast<float>(c.x()), static_cast<float>(c.y()), static_cast<float>(c.z()), n.sphere.radius};
    out.exact[slot] = {c.x(), c.y(), c.z()};
    if (n.leaf != kNotALeaf) {
      out.node[slot] = leaves.node[n.leaf];
      out.reach = std::max(out.reach, c.norm() + static_cast<double>(n.sphere.radius));
      out.smallest_radius = std::min(out.smallest_radius, n.sphere.radius);
    } else {
      // Inner siblings stand ahead of leaves, and inner nodes are numbered as they come: their blocks follow each other.
      BlockLinks& links = out.links[slot / 8];
      if (slot % 8 == 0) links.first_child = next_block;
      ++next_block;
      ++links.inner;
      links.open_priority[slot % 8] = open_priority(n.sphere.radius, n.child_count);
    }
  };
  putNode(0, leaves.tree[0]);
  std::size_t block = 1;
  for (const SearchNode& n : leaves.tree) {
    for (std::uint32_t k = 0; k < n.child_count; ++k) putNode(8 * block + k, leaves.tree[n.first_child + k]);
    block += n.child_count > 0;
  }
  return out;
}

std::string faultInSettings(const SceneDescription& d) {
  const auto bad = [](const char* what, double value, const char* range) {
    char number[32];
    std::snprintf(number, sizeof number, "%.9g", value);
    return std::string(what) + " is " + number + "; it must be " + range;
  };
  if (!inRange(d.coupling.translation, 1e-6, 1e6)) return bad("translation stiffness [N/mm]", d.coupling.translation, "within 1e-6 .. 1e6");
  if (!inRange(d.coupling.rotation, 1e-6, 1e9)) return bad("rotation stiffness [N mm/rad]", d.coupling.rotation, "within 1e-6 .. 1e9");
  if (!inRange(d.wrench_limits.force, 1e-9, 1e6)) return bad("force limit [N]", d.wrench_limits.force, "above 0, at most 1e6");
  for (int k = 0; k < 3; ++k)
    if (!inRange(d.wrench_limits.torque[k], 1e-9, 1e9))
      return bad("torque limit [N mm]", d.wrench_limits.torque[k], "above 0, at most 1e9");
  const double least = std::max<double>(64, 64.0 * static_cast<double>(d.objects.size()));
  if (!inRange(d.step_limits.max_pairs, least, 1 << 20)) return bad("max_pairs", d.step_limits.max_pairs, "64 for each object .. 1048576");
  if (!inRange(d.step_limits.max_work, 1000, 1 << 30)) return bad("max_work", d.step_limits.max_work, "within 1000 .. 1073741824");
  return {};
}

// In a tree with regions of work the leaves elsewhere reach out farther, and what bridges them would bury the work.
BridgeTree bridgesOf(const SphereTree& tree, std::span<const Sphere> leaves, const Eigen::Matrix3d& rotation) {
  const float at_work = tree.provenance.work_overhang_mm;
  return makeBridges(leaves, static_cast<double>(at_work > 0 ? at_work : tree.statistics.back().overhang_bound), at_work > 0, rotation);
}

// Those of the object that comes next.
void addBridges(BridgeTree tree, const Eigen::Vector3d& anchor, Scene& scene) {
  if (tree.count == 0) return;
  const Eigen::Vector3d centre(tree.root.x, tree.root.y, tree.root.z);
  if (scene.bridges.size() % 8 == 0) scene.bridge_roots.push_back(emptyBlock());
  put(scene.bridge_roots.back(), scene.bridges.size() % 8, anchor + centre, tree.root.radius);
  scene.objects_reach = std::max(scene.objects_reach, centre.norm() + static_cast<double>(tree.root.radius));
  scene.bridges.push_back({static_cast<std::uint32_t>(scene.objects.size()), std::move(tree)});
}

constexpr double kFarthest = 1e7;  // [mm]; beyond it float cannot tell a micrometre from ten metres away

}  // namespace

bool compileScene(const SceneDescription& d, Scene& scene, std::string& fault) {
  fault = faultInSettings(d);
  if (!fault.empty()) return false;
  if (std::string why = findFault(d.tool); !why.empty()) {
    fault = "tool: " + why;
    return false;
  }
  if (!d.reference_point.allFinite()) {
    fault = "tool: the reference point is not finite";
    return false;
  }
  Scene out;
  out.coupling = d.coupling;
  out.wrench_limits = d.wrench_limits;
  out.step_limits = d.step_limits;
  out.angle_length = std::sqrt(d.coupling.rotation / d.coupling.translation);
  out.tool = compileTree(Leaves(d.tool), [&](const Eigen::Vector3d& c) -> Eigen::Vector3d { return c - d.reference_point; });
  const Block& root = out.tool.bound[0];
  out.tool_root = Eigen::Vector3d(root.x[0], root.y[0], root.z[0]);
  out.tool_root_radius = static_cast<double>(root.r[0]);
  if (!(out.tool.reach <= kFarthest)) {
    fault = "tool: a sphere is " + std::to_string(out.tool.reach) + " mm from the reference point; at most 1e7 mm";
    return false;
  }
  float smallest = std::numeric_limits<float>::infinity();
  for (std::size_t i = 0; i < d.objects.size(); ++i) {
    const SceneObject& object = d.objects[i];
    const std::string name = "object " + std::to_string(i) + ": ";
    if (std::string why = findFault(object.tree); !why.empty()) {
      fault = name + why;
      return false;
    }
    if (!isFinite(object.pose)) {
      fault = name + "the pose is not finite or its quaternion is null";
      return false;
    }
    const Eigen::Matrix3d rotation = object.pose.orientation.normalized().toRotationMatrix();
    const Leaves leaves(object.tree);
    const Eigen::Vector3d centre = leaves.centre(leaves.tree[0]);
    CompiledObject compiled;
    compiled.anchor = rotation * centre + object.pose.position;
    compiled.tree = compileTree(leaves, [&](const Eigen::Vector3d& c) -> Eigen::Vector3d { return rotation * (c - centre); });
    compiled.root_radius = static_cast<double>(leaves.tree[0].sphere.radius);
    if (!(compiled.anchor.norm() <= kFarthest && compiled.tree.reach <= kFarthest)) {
      fault = name + "it reaches farther than 1e7 mm from the origin of the world";
      return false;
    }
    smallest = std::min(smallest, compiled.tree.smallest_radius);
    out.objects_reach = std::max({out.objects_reach, compiled.tree.reach, compiled.root_radius});
    out.farthest_anchor = std::max(out.farthest_anchor, compiled.anchor.norm());
    if (i % 8 == 0) out.object_roots.push_back(emptyBlock());
    put(out.object_roots.back(), i % 8, compiled.anchor, leaves.tree[0].sphere.radius);
    if (d.bridges) addBridges(bridgesOf(object.tree, leaves.about(centre), rotation), compiled.anchor, out);
    out.objects.push_back(std::move(compiled));
  }
  out.smallest_radius_sum = static_cast<double>(out.tool.smallest_radius) + static_cast<double>(smallest);
  scene = std::move(out);
  return true;
}

}  // namespace spheretree::runtime
