// SPDX-License-Identifier: Apache-2.0
// The content of a Scene: the tool, the shapes (each sphere-tree once, however many objects share it), and the objects
// with their poses.
// Frames. Tool: origin at its reference point, tool axes. Object: origin at the centre of its root, axes of its file.
#pragma once

#include <memory>
#include <vector>

#include "scene/compiled_hulls.h"
#include "scene/compiled_skin.h"
#include "scene/compiled_tree.h"
#include "spheretree/runtime/scene.h"

namespace spheretree::runtime {

class Cutting;
class SoftTissue;
struct StepMemory;

struct CompiledShape {
  const void* of = nullptr;  // address of its tissue, or else of its tree, in the description
  CompiledTree leaves;
  CompiledSkin skin;                          // empty: the tool rests on the leaves
  std::vector<std::uint32_t> nodes;           // (leaf) node index in the SphereTree
  Eigen::Vector3d centre;                     // origin of the compiled shape, in the frame of the mesh [mm]
  std::shared_ptr<const TissueModel> tissue;  // null: rigid
  std::shared_ptr<const CutModel> cut;        // null: no burr cuts it
  double radius = 0;                          // of a ball about the centre that contains leaves and skin [mm]
  float overhang = kUnproven;                 // proven: no leaf reaches farther out of the mesh [mm]
  float mesh_distance = 0;                    // proven: two-sided distance of the skin's flat triangles and the mesh [mm]
};

struct CompiledObject {
  std::uint32_t shape, body;
  double friction = 0;       // coefficient of its contacts with the tool
  double softness = 0;       // sqrt(stiffness of the tool's spring / stiffness of the object); 0: rigid
  Eigen::Matrix3d rotation;  // axes of the shape to world axes
  Eigen::Vector3d anchor;    // the shape's centre in the world [mm]
  // In StepMemory::at_home: the next object of the same body (~0u: none), and the body's pose that the views are for.
  std::uint32_t next_of_body = ~0u, placed_for = 0;
};

struct CompiledScene {
  CompiledTree tool;
  CompiledHulls hulls;                    // of the tool; empty: its leaves rest on the objects
  std::vector<std::uint32_t> tool_nodes;  // (leaf) node index in the tool's SphereTree
  std::vector<std::uint32_t> tool_parts;  // (slot) connected part of a leaf: if none of its leaves is in a skin, all are on the same side
  std::uint32_t tool_part_count = 0;
  Eigen::Vector3d tool_root;        // centre of its root relative to the reference point, tool axes [mm]
  double tool_root_radius = 0;      // of a ball there that contains leaves and hulls [mm]
  float tool_overhang = kUnproven;  // proven: no leaf reaches farther out of the tool's mesh [mm]
  std::vector<CompiledShape> shapes;
  std::vector<CompiledObject> objects;
  std::uint32_t body_count = 1;  // including the world, body 0
  double step_time = 0.001;      // [s]
  double objects_reach = 0;      // largest distance of a point of an object from its anchor [mm]
  Coupling coupling;
  Coupling pull;     // spring, damper and mass as one stiffness, with the step time T: stiffness + damping / T + mass / T^2
  Coupling inertia;  // the term mass / T^2 of this stiffness
  bool has_friction = false, has_soft = false;                               // of any kind
  std::unique_ptr<SoftTissue> (*make_tissue)(StepMemory& memory) = nullptr;  // null: the scene has no tissue
  std::unique_ptr<Cutting> (*make_cutting)(StepMemory& memory) = nullptr;    // null: nothing is cut
  std::vector<Sphere> burr;                                                  // relative to the reference point, tool axes
  Eigen::Vector3d spindle_axis = Eigen::Vector3d::UnitZ();                   // tool axes
  std::uint32_t burr_slot = 0;                                               // the balls of the burr follow the leaves in tool.spheres
  std::vector<std::uint32_t> burr_of;     // (slot) ball of the burr that a leaf covers; kNoItem: it is another part of the tool
  std::vector<std::uint32_t> wall_slots;  // what meets the walls of what was cut: other leaves, then the balls of the burr
  WrenchLimits wrench_limits;
  StepLimits step_limits;
  double angle_length = 0;   // sqrt(rotation / translation stiffness) of the pull: the length that corresponds to 1 rad [mm]
  double min_contact = 0;    // smallest distance at which a ball of the tool is held: the sum of two radii (leaves), or half of its radius
                             // (skin) [mm] inside the other [mm]
  float skin_tolerance = 0;  // largest of the shapes [mm]

  /// What of the tool rests on the objects, or its leaves.
  const CompiledTree& toolTree(bool leaves) const { return leaves || hulls.empty() ? tool : hulls.tree; }
  /// Takes another coupling. The stiffness of objects stays; their `softness` is relative to the coupling.
  void couple(const Coupling& other);
  /// An object of this shape and body, with its mesh frame at `pose`.
  CompiledObject placed(std::uint32_t shape, std::uint32_t body, const Configuration& pose) const;
  const CompiledShape& shapeOf(std::size_t object) const { return shapes[objects[object].shape]; }
};

}  // namespace spheretree::runtime
