// SPDX-License-Identifier: Apache-2.0
// All memory that changes while a scene is rendered: scratch lists and the state from step to step. Sized once; a step allocates nothing.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "spheretree/runtime/collide.h"
#include "spheretree/runtime/contact.h"
#include "spheretree/runtime/scene.h"

namespace spheretree::runtime {

struct KernelTable;
struct ObjectView;
struct HitGroup;

/// What names a row from step to step.
struct PairName {
  std::uint32_t object = 0, pair = 0;  // of a bridge: index in Scene::bridges
  bool is_bridge = false;
  friend bool operator==(const PairName&, const PairName&) = default;
};

/// What the tool is searched against, objects or their bridges, and what was found.
struct Targets {
  std::vector<ObjectView> views, near_views;
  std::vector<std::uint32_t> near, near_counts, pairs;
  std::vector<PairRun> runs;
};

class Workspace {
 public:
  /// For `scene`, which must outlive it. `kernel` that is not available falls back to Scalar. @throws std::bad_alloc.
  explicit Workspace(const Scene& scene, Kernel kernel = Kernel::Best);
  ~Workspace();
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;

  const KernelTable* kernel;

  // Scratch of findPairs() and makeRows().
  std::vector<Block> turned_tool;          // bounding spheres in world axes, about the reference point
  std::vector<std::uint32_t> turned_when;  // (block) the search that turned it last
  std::uint32_t pose_count = 0;            // searches so far
  Targets objects, bridges;
  std::vector<HitGroup> leaves, open_tool, open_object;
  struct FreeFloats {
    void operator()(float* p) const;
  };
  std::unique_ptr<float[], FreeFloats> row_memory;  // 8 arrays of row_stride: a, b, weight; 64-byte aligned
  std::size_t row_stride = 0;

  // State from step to step.
  bool started = false;
  bool is_behind = false;                  // the graphic tool had not arrived when the last step ended
  Configuration haptic, graphic;           // of the last step
  std::array<double, 3> euler{};           // of the graphic tool in paper mode: gamma, beta, alpha [rad]
  Wrench wrench;                           // of the last step, not limited
  std::array<PairName, 6> active_names{};  // rows that were active at the end of the last step
  std::uint8_t active_count = 0;
  QpAnswer answer;  // of the last QP
};

}  // namespace spheretree::runtime
