// SPDX-License-Identifier: Apache-2.0
// What Workspace hides: scratch lists, and the state from step to step. Sized once; a step allocates nothing.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "compiled_scene.h"
#include "find_pairs.h"
#include "kernel.h"
#include "moving_bodies.h"
#include "qp6.h"
#include "soft_tissue.h"
#include "spheretree/runtime/step.h"

namespace spheretree::runtime {

static_assert(kMostContacts == kMostContactRows);

inline constexpr std::size_t kRowArrays = 9;  // of StepMemory::row_memory: six of coefficients, b, weight, felt way

/// What names a row from step to step.
struct RowName {
  std::uint32_t object = 0, pair = 0;
  bool is_felt = false;  // the row of the smooth patch, not of the flat triangle
  friend bool operator==(const RowName&, const RowName&) = default;
};

struct StepMemory {
  /// `kernel` that is not available falls back to Scalar. @throws std::bad_alloc.
  StepMemory(const CompiledScene& scene, Kernel kernel);

  const CompiledScene& scene;
  const KernelTable* kernel;

  // The objects where they are now, and what carries them.
  std::vector<CompiledObject> objects;
  std::vector<CompiledObject> at_home;  // in the axes of their bodies
  std::vector<MovingBody> bodies;       // the world is the first
  bool bodies_move = false;             // some have not yet gone to where they are to be in this step
  std::vector<Block> object_roots;      // balls about them in the world, 8 to a block
  double farthest_anchor = 0;           // from the origin of the world [mm]

  // Scratch of findPairs() and of the rows.
  std::vector<Block> turned_tool;          // balls of the tool in the axes of an object, about the reference point
  std::vector<std::uint32_t> turned_when;  // (block) the search of an object that turned it last
  std::uint32_t turn_count = 0;            // searches of objects so far
  std::vector<ObjectView> leaf_views;      // (object)
  std::vector<ObjectView> views;           // (object) of what the tool is to meet now: its skin or its leaves
  std::vector<std::uint32_t> near, near_counts, pairs, felt_pairs;
  std::vector<PairRun> runs, felt_runs;
  std::vector<HitGroup> leaves, open_tool, open_object;
  struct FreeFloats {
    void operator()(float* p) const;
  };
  std::unique_ptr<float[], FreeFloats> row_memory;  // kRowArrays of row_stride; 64-byte aligned
  std::size_t row_stride = 0;
  float* rowArray(std::size_t k) { return row_memory.get() + k * row_stride; }

  // State from step to step.
  bool started = false;
  bool sides_known = false;                           // it is settled on which side of each skin the tool is
  std::uint32_t leaves_felt = 0;                      // objects with a skin whose leaves are felt instead, since the tool started inside
  bool is_behind = false;                             // the graphic tool had not arrived when the last step ended
  Configuration haptic, graphic;                      // of the last step
  std::array<double, 3> euler{};                      // of the graphic tool in the mode of the paper: gamma, beta, alpha [rad]
  Wrench wrench;                                      // of the last step, not limited
  std::array<RowName, kMostContacts> active_names{};  // rows that were active at the end of the last step
  std::uint8_t active_count = 0;
  std::array<double, kMostContacts> active_multiplier{};        // of these rows
  std::array<Eigen::Vector3d, kMostContacts> active_rubbing{};  // the force of friction, over the stiffness of the pull [mm]
  std::vector<double> give, give_from, give_to;                 // (object) how far it gives way: now, and in the piece to come [mm]
  std::vector<float> soft_b;                                    // (row) b of objects that give way
  std::unique_ptr<SoftTissue> tissue;                           // null: there is none
  double depth = 0;                                             // of the tool in something when the last step ended [mm]
  Displacement stretch;                                         // of spring and damper when the last step ended
  Displacement motion;                                          // of the graphic tool in the last step, if it goes on by its mass
  QpAnswer answer;                                              // of the last QP
  std::array<Contact, kMostContacts> contacts{};
  std::uint8_t contact_count = 0;

  bool feelsSkin(std::size_t object) const { return views[object].patches != nullptr; }
  /// Puts an object elsewhere.
  void place(std::size_t object, const Configuration& pose);
  /// Puts the object where its body, with this rotation and position, carries it.
  void carry(std::size_t object, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& position);
  /// Not while its leaves are felt, as those of a rigid object.
  bool isTissue(std::size_t object) const { return tissue && feelsSkin(object) && tissue->has(object); }
  void feelLeaves(std::size_t object);
  void feelSkin(std::size_t object);

 private:
  void placeViews(std::size_t object);
  ObjectView skinView(std::size_t object) const;
};

}  // namespace spheretree::runtime
