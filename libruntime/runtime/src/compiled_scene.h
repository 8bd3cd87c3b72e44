// SPDX-License-Identifier: Apache-2.0
// What Scene hides: the tool, the shapes (each sphere-tree once, however many objects share it), and the objects in
// their places.
// Tool: about its reference point, in tool axes. Body: about the centre of its root, in the axes of its file.
#pragma once

#include <memory>
#include <vector>

#include "compiled_skin.h"
#include "compiled_tree.h"
#include "spheretree/runtime/scene.h"

namespace spheretree::runtime {

class SoftTissue;
struct StepMemory;

struct CompiledShape {
  const void* of = nullptr;  // its tissue, or else its tree, in the description
  CompiledTree leaves;
  CompiledSkin skin;                          // empty: the leaves are felt
  std::vector<std::uint32_t> nodes;           // (leaf) node of the SphereTree
  Eigen::Vector3d centre;                     // what the shape is about, in the frame of the mesh [mm]
  std::shared_ptr<const TissueModel> tissue;  // null: rigid
  double radius = 0;                          // of a ball about the centre that holds leaves and skin [mm]
};

struct CompiledObject {
  std::uint32_t shape, body;
  double friction = 0;       // with the tool
  double softness = 0;       // sqrt(stiffness of the tool's spring / its own); 0: rigid
  Eigen::Matrix3d rotation;  // axes of the shape to world axes
  Eigen::Vector3d anchor;    // the shape's centre in the world [mm]
};

struct CompiledScene {
  CompiledTree tool;
  std::vector<std::uint32_t> tool_nodes;  // (leaf) node of the tool's SphereTree
  Eigen::Vector3d tool_root;              // centre of its root about the reference point, tool axes [mm]
  double tool_root_radius = 0;            // [mm]
  std::vector<CompiledShape> shapes;
  std::vector<CompiledObject> objects;
  std::uint32_t body_count = 1;  // the world, 0, among them
  double step_time = 0.001;      // [s]
  double objects_reach = 0;      // no point of an object is farther from its anchor [mm]
  Coupling coupling;
  Coupling pull;                                // all in one spring, as a step of length T feels it: stiffness + damping / T + mass / T^2
  Coupling inertia;                             // the last part of this stiffness
  bool has_friction = false, has_soft = false;  // of any kind
  std::unique_ptr<SoftTissue> (*make_tissue)(StepMemory& memory) = nullptr;  // null: there is none
  WrenchLimits wrench_limits;
  StepLimits step_limits;
  double angle_length = 0;   // sqrt(rotation / translation stiffness) of the pull: 1 rad weighs as much as this [mm]
  double least_contact = 0;  // no ball of the tool comes nearer to what it meets than this before the centre of one is in the other [mm]
  float skin_tolerance = 0;  // largest of the shapes [mm]

  /// An object of this shape and body with its mesh frame at `pose`.
  CompiledObject placed(std::uint32_t shape, std::uint32_t body, const Configuration& pose) const;
  const CompiledShape& shapeOf(std::size_t object) const { return shapes[objects[object].shape]; }
};

}  // namespace spheretree::runtime
