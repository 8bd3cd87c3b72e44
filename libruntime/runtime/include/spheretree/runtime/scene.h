// SPDX-License-Identifier: Apache-2.0
// A scene, compiled once and constant from then on: the tool's tree, the objects' trees in their places, stiffness and limits.
//
// Of a sphere-tree the search needs the leaves: they get a tree of their own when the scene is compiled (docs/runtime.md, Search tree).
// Layout: the children of an inner node stand in one 128-byte block of 8 lanes, so that one sphere is tested against all of them
// at once. A node is named by its slot = 8 * block + lane; the root is slot 0, alone in block 0. Empty lanes are far away.
// Tool: about its reference point, in tool axes. Object: about its anchor, in world axes (it is turned into them once, here).
// Units: mm, N, N mm, rad.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "spheretree/core/rigid.h"
#include "spheretree/core/sphere_tree.h"
#include "spheretree/runtime/bridge.h"

namespace spheretree::runtime {

/// The spring between haptic and graphic tool; both > 0.
struct Coupling {
  double translation = 1;  // [N/mm]
  double rotation = 1000;  // [N mm/rad]
};

/// Largest wrench that is rendered; all > 0.
struct WrenchLimits {
  double force = 8;                      // of the vector [N]
  Eigen::Vector3d torque{188, 188, 48};  // of each component, world axes [N mm]
};

/// What one step may cost. Both are counts, not clock time, so that a step is the same on every machine.
struct StepLimits {
  std::uint32_t max_pairs = 8192;    // leaf pairs at a time; 64 for each object .. 2^20
  std::uint32_t max_work = 100'000;  // 8-lane tests and groups of 8 rows (about 3 ns each) in a step; 1'000 .. 2^30
};

/// The defaults, with as many pairs as this number of objects needs.
inline StepLimits defaultLimits(std::size_t object_count) {
  StepLimits limits;
  limits.max_pairs = std::max(limits.max_pairs, 64 * static_cast<std::uint32_t>(object_count));
  return limits;
}

struct SceneObject {
  SphereTree tree;
  Configuration pose;  // of the tree's mesh frame in the world
};

struct SceneDescription {
  SphereTree tool;
  Eigen::Vector3d reference_point = Eigen::Vector3d::Zero();  // in the mesh frame of the tool [mm]
  std::vector<SceneObject> objects;
  Coupling coupling;
  WrenchLimits wrench_limits;
  StepLimits step_limits;
  bool bridges = true;  // constrained mode slides over the pits between an object's leaves, where its tree states an overhang: bridge.h
};

struct alignas(128) Block {
  float x[8], y[8], z[8], r[8];
};
static_assert(sizeof(Block) == 128);

/// Lanes [0, inner) of a block are inner nodes, the others leaves or empty. The children of lane k stand in block first_child + k.
struct BlockLinks {
  std::uint16_t first_child = 0, inner = 0;
  float open_priority[8] = {};  // (lane) of inner nodes: radius for each child [mm]; of two nodes that with the larger one is opened
};

struct CompiledTree {
  std::vector<Block> bound;                  // what the search tests: leaves, and the smallest balls about those below an inner node
  std::vector<Sphere> spheres;               // (slot) the same spheres, each in one piece
  std::vector<BlockLinks> links;             // (block)
  std::vector<std::array<double, 3>> exact;  // (slot) centre before rounding to float
  std::vector<std::uint32_t> node;           // (slot) index of the leaf in the SphereTree; kNoNode for an inner node or an empty lane
  double reach = 0;                          // no point of any sphere is farther from the frame's origin [mm]
  float smallest_radius = 0;                 // of the leaves [mm]

  bool isInner(std::size_t slot) const { return slot % 8 < links[slot / 8].inner; }
};
inline constexpr std::uint32_t kNoNode = 0xffffffffu;

struct CompiledObject {
  CompiledTree tree;
  Eigen::Vector3d anchor;  // world [mm]; centre of the smallest ball about the leaves
  double root_radius;      // its radius [mm]
};

/// The bridges of an object, about its anchor.
struct CompiledBridges {
  std::uint32_t object;
  BridgeTree tree;
};

struct Scene {
  CompiledTree tool;
  Eigen::Vector3d tool_root;    // centre of its root about the reference point, tool axes [mm]
  double tool_root_radius = 0;  // [mm]
  std::vector<CompiledObject> objects;
  std::vector<Block> object_roots;       // bounding spheres of the objects in the world, 8 to a block
  std::vector<CompiledBridges> bridges;  // of the objects that have some
  std::vector<Block> bridge_roots;       // as object_roots
  double objects_reach = 0;              // no point of an object is farther from its anchor [mm]
  double farthest_anchor = 0;            // of the objects from the origin of the world [mm]
  Coupling coupling;
  WrenchLimits wrench_limits;
  StepLimits step_limits;
  double angle_length = 0;         // sqrt(rotation / translation stiffness): 1 rad weighs as much as this [mm]
  double smallest_radius_sum = 0;  // of a tool leaf and an object leaf [mm]
};

/// Checks the description and compiles it. False with a sentence in `fault` (which part, what, what to do) if a tree is unsound
/// (findFault), a pose is not finite, or a limit is out of range; `scene` is then unchanged.
/// Cost: O(nodes * levels), 5 ms for 512 leaves, 35 with bridges; allocates all that the scene will ever hold.
[[nodiscard]] bool compileScene(const SceneDescription& description, Scene& scene, std::string& fault);

}  // namespace spheretree::runtime
