// SPDX-License-Identifier: Apache-2.0
// An object that the burr cuts: what is left of it, and the burr near it.
// Units: mm; axes of the object.
#pragma once

#include <cstdint>
#include <vector>

#include "cut/cut_lattice.h"
#include "cut/cut_layers.h"
#include "scene/cut_model.h"
#include "state/step_memory.h"

namespace spheretree::runtime {

/// A ball of the burr near an object.
struct NearBall {
  Eigen::Vector3d at{0, 0, 0};           // its centre at the beginning of the step
  bool is_near = false;                  // in this step
  Eigen::Vector3d known_about{0, 0, 0};  // all blocks within known_within of this point have been made
  double known_within = 0;
};

struct CutWork {
  std::uint32_t object;  // index in the scene
  const CompiledShape& shape;
  const CutModel& model;
  CutLayers layers;
  CutLattice lattice;
  std::vector<double> removed;            // (layer) [mm^3]
  std::uint32_t layer = CutState::kNone;  // innermost that the burr met in the last step
  std::vector<NearBall> burr;             // (ball)

  Eigen::Vector3d localOf(const Eigen::Vector3d& world, const StepMemory& memory) const {
    const CompiledObject& at = memory.objects[object];
    return at.rotation.transpose() * (world - at.anchor);
  }
};

/// Centre of a ball of the tool at a pose of the tool, world axes.
inline Eigen::Vector3d placeOf(const Configuration& pose, const Sphere& ball) { return pose.position + pose.orientation * centreOf(ball); }

}  // namespace spheretree::runtime
