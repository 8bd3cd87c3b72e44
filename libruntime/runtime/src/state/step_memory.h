// SPDX-License-Identifier: Apache-2.0
// The content of a Workspace: scratch lists, and the state between steps. It is allocated once; a step allocates
// nothing.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "contact/contact_problem.h"
#include "contact/qp6.h"
#include "kernel/kernel.h"
#include "scene/compiled_scene.h"
#include "spheretree/runtime/step.h"
#include "state/cutting.h"
#include "state/moving_body.h"
#include "state/pair_set.h"
#include "state/soft_tissue.h"

namespace spheretree::runtime {

static_assert(kMaxContacts == kMaxContactRows);

inline constexpr std::size_t kRowArrays =
    10;  // number of arrays in StepMemory::row_memory: six of coefficients, b, weight, felt way, along

/// Identifies a row from step to step.
struct RowName {
  std::uint32_t object = 0, pair = 0;
  bool is_felt = false;  // true: row of the smooth patch; false: of the flat triangle
  bool of_wall = false;  // of what was cut off
  friend bool operator==(const RowName&, const RowName&) = default;
};

struct StepMemory {
  /// If `kernel` is not available, Scalar is used. @throws std::bad_alloc.
  StepMemory(const CompiledScene& scene, Kernel kernel);

  const CompiledScene& scene;
  const KernelTable* kernel;

  // The current poses of the objects, and the bodies that move them.
  std::vector<CompiledObject> objects;
  std::vector<CompiledObject> at_home;  // poses relative to their bodies
  std::vector<MovingBody> bodies;       // index 0 is the world
  std::uint32_t away_count = 0;         // bodies that are away
  Eigen::Vector3d away_from{0, 0, 0};   // no body that is away comes nearer to this point of the world
  double away_by = 0;                   // than this [mm]
  std::vector<MovingBody*> moving;      // the first moving_count have not yet reached their target of this step
  std::size_t moving_count = 0;
  std::span<MovingBody* const> movingBodies() const { return {moving.data(), moving_count}; }
  std::vector<Block> object_roots;  // bounding spheres of the objects in the world, 8 to a block
  double farthest_anchor = 0;       // from the origin of the world [mm]

  // Scratch memory of findPairs() and of the rows.
  std::vector<Block> turned_tool;          // balls of the tool in the axes of an object, relative to the reference point
  std::vector<std::uint32_t> turned_when;  // (block) number of the search that rotated it last
  std::uint32_t turn_count = 0;            // number of searches of objects so far
  std::vector<ObjectView> leaf_views;      // (object)
  std::vector<ObjectView> views;           // (object) what the tool rests on now: its skin or its leaves
  std::vector<std::uint32_t> near, near_counts, pairs, felt_pairs;
  std::vector<PairRun> runs, felt_runs;
  std::vector<HitGroup> leaves, open_tool, open_object;
  struct FreeFloats {
    void operator()(float* p) const;
  };
  std::unique_ptr<float[], FreeFloats> row_memory;  // kRowArrays arrays of row_stride; 64-byte aligned
  std::size_t row_stride = 0;
  float* rowArray(std::size_t k) { return row_memory.get() + k * row_stride; }

  // State between steps.
  bool started = false;
  bool sides_known = false;        // it is known on which side of each skin the tool is
  std::uint32_t leaves_felt = 0;   // number of objects with a skin whose leaves are used instead, since the tool started inside
  std::vector<char> part_settled;  // (part of the tool) scratch: its side of the skin of an object has been determined
  bool is_behind = false;          // the graphic tool had not arrived at the end of the last step
  Configuration aim;               // where spring, damper and mass pulled the tool in the last step,
  Configuration haptic, graphic;   // where to by its contacts, which is less far if a burr cuts; and where it came
  bool has_euler = false;          // the last step was one of the published mode, which continues with its own angles:
  std::array<double, 3> euler{};   // Euler angles of the graphic tool, gamma, beta, alpha [rad]
  Wrench wrench;                   // of the last step, without the limits
  std::array<RowName, kMaxContacts> active_names{};  // rows that were active at the end of the last step
  std::uint8_t active_count = 0;
  std::array<double, kMaxContacts> active_multiplier{};        // multipliers of these rows
  std::array<Eigen::Vector3d, kMaxContacts> active_rubbing{};  // friction force, divided by the stiffness of the pull [mm]
  std::vector<double> give, give_before, give_from, give_to;   // (object) how far it yields: now, and from and to in the next piece [mm]
  std::vector<float> soft_b;                                   // (row) b, for objects that yield
  std::unique_ptr<SoftTissue> tissue;                          // null if the scene has no tissue
  std::unique_ptr<Cutting> cutting;                            // null: nothing is cut
  double depth = 0;                                            // penetration of the tool at the end of the last step [mm]
  Displacement stretch;                                        // of spring and damper at the end of the last step
  Displacement motion;                                         // motion of the graphic tool in the last step, which its mass continues
  std::unique_ptr<ContactProblem> contact_problem;             // of the piece; null without friction and compliance
  QpAnswer answer;                                             // of the last QP
  std::array<Contact, kMaxContacts> contacts{};
  std::uint8_t contact_count = 0;

  bool feelsSkin(std::size_t object) const { return views[object].patches != nullptr; }
  /// Places the views of the object where objects[object] says.
  void placeViews(std::size_t object);
  /// Places its bounding sphere, of this radius, where objects[object] says. It stays switched off if it is.
  void placeRoot(std::size_t object, float radius);
  /// The root of an object that is switched off has NaN for its radius: no search finds it.
  bool isActive(std::size_t object) const;
  void switchOff(std::size_t object);
  void switchOn(std::size_t object);
  /// False while its leaves are used, which are those of a rigid object.
  bool isTissue(std::size_t object) const { return tissue && feelsSkin(object) && tissue->has(object); }
  void feelLeaves(std::size_t object);
  void feelSkin(std::size_t object);

 private:
  ObjectView skinView(std::size_t object) const;
};

}  // namespace spheretree::runtime
