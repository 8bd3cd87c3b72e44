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
  std::uint32_t object = 0, pair = 0;  // `pair` of a bridge: the slot of the tool's leaf
  std::uint32_t bridge = 0;            // index + 1; 0: a pair of leaves
  friend bool operator==(const PairName&, const PairName&) = default;
};

/// A bridge that a leaf of the tool may come to touch before the next search.
struct NearBridge {
  std::uint32_t object, tool_slot, bridge;
};

// Of one search, and of one linearisation; what goes beyond is left out: there the bumps are felt.
inline constexpr std::size_t kMostNearBridges = 16384, kMostBridgeRows = 4096;

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
  std::vector<ObjectView> object_views, near_views;
  std::vector<std::uint32_t> near_objects;
  std::vector<HitGroup> leaves, open_tool, open_object;
  std::vector<std::uint32_t> near_counts, pairs;
  std::vector<PairRun> runs;
  struct FreeFloats {
    void operator()(float* p) const;
  };
  std::unique_ptr<float[], FreeFloats> row_memory;  // 8 arrays of row_stride: a, b, weight; 64-byte aligned
  std::size_t row_stride = 0;
  std::vector<NearBridge> near_bridges;
  std::vector<PairName> bridge_rows;  // names of the rows that follow those of the pairs

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
