// SPDX-License-Identifier: Apache-2.0
// The inner loops, compiled once for each instruction set from one source (kernel_lanes.h). All give the same bits: the same IEEE
// operations in the same order, no contraction.
#pragma once

#include <array>
#include <cstdint>

#include "spheretree/runtime/scene.h"

namespace spheretree::runtime {

/// An object as the search sees it; all that it reads of an object before the blocks.
struct alignas(64) ObjectView {
  const Block* bound;
  const BlockLinks* links;
  const std::array<double, 3>* exact;  // (slot) world axes, about the anchor
  const double* anchor;                // world
  float offset[3];                     // reference point of the tool from the anchor, world axes [mm]; of a near object
};

/// Up to 8 pairs that one test found: one node of the tool or of an object, and some lanes of a block of the other side.
struct HitGroup {
  std::uint32_t name;             // of the pair of lane 0: tool slot << 16 | object slot
  std::uint32_t near : 16;        // which of the near objects
  std::uint32_t many : 16;        // block to be tested next, of the side that is opened; the children of lane 0, if it is the lanes' side
  std::uint32_t lanes : 8;        // bit k: lane k was hit
  std::uint32_t tool_varies : 1;  // the lanes are slots of the tool, not of the object
};

struct PairSearch {
  const Block *tool, *object_roots;
  const BlockLinks* tool_links;
  const std::array<double, 3>* exact_tool;  // (slot) about the reference point, tool axes; null: no pair is in doubt
  const ObjectView* objects;
  std::uint32_t object_count;
  double rotation[9];                          // tool axes to world axes, row-major
  double position[3];                          // of the reference point, world
  double margin;                               // [mm]
  float root[4];                               // bounding sphere of the tool in the world, radius with all that the broad phase adds
  float inner_margin;                          // the margin and all that rounding can lose; beyond it no pair is in
  float sure_margin;                           // pairs of leaves within this are in, in float; between, double decides
  Block* turned_tool;                          // a block is turned into world axes, about the reference point, when it is first met
  std::uint32_t* turned_when;                  // (block) the `now` of its last turn
  std::uint32_t now;                           // names the pose
  std::uint32_t* near_objects;                 // output; [0, object_count + 8)
  ObjectView* near_views;                      // of them
  HitGroup *leaves, *open_tool, *open_object;  // scratch, list_capacity each
  std::uint32_t* pairs;                        // output; [0, capacity + 8), by object
  std::uint32_t* near_counts;                  // output: pairs of each near object
  std::uint32_t capacity, list_capacity, max_work;
};

struct PairSearchResult {
  std::uint32_t count, near_count, work;
  bool coarse;
};

struct RowRequest {
  const std::uint32_t* pairs;
  std::uint32_t count;
  const Sphere* tool;    // (slot) as it stands in the scene
  float rotation[9];     // tool axes to world axes, row-major
  const Sphere* object;  // (slot)
  float offset[3];
  float inverse_angle_length;
  bool squared;   // RowForm::SquaredDistance
  float axes[9];  // row k: the axis of angle k; used if `squared`
  float* a[6];    // written to [0, count + 8)
  float* b;
  float* weight;
};

/// Balls of the tool with bridges of one tree.
struct BridgeRequest {
  const std::uint32_t* pairs;  // readable to [0, count + 8)
  std::uint32_t count;
  const Sphere* tool;     // (slot) as it stands in the scene
  float rotation[9];      // tool axes to world axes, row-major
  const Bridge* bridges;  // (slot)
  float offset[3];
  float inverse_angle_length, most_gap;
};

/// Where rows are written to, [0, count + 8).
struct RowMemory {
  float* a[6];
  float* b;
  float* weight;
};

struct WorstRow {
  std::uint32_t row;  // lowest index among equals
  float slack;        // a . y - b
};

struct KernelTable {
  PairSearchResult (*findPairs)(const PairSearch&);
  float (*makeRows)(const RowRequest&);  // returns the smallest gap
  // Those of the pairs whose ball may come to touch the bridge before it has moved by most_gap, to `to`, which may be q.pairs; their
  // number.
  std::uint32_t (*nearBridges)(const BridgeRequest& q, std::uint32_t* to);
  // True distances; a bridge that the ball does not touch where it is gets a row that is in no one's way.
  void (*makeBridgeRows)(const BridgeRequest&, const RowMemory&);
  WorstRow (*worstRow)(const float* const* a, const float* b, std::uint32_t count, const float* y);  // count > 0
};

const KernelTable& scalarKernel();
const KernelTable* avx2Kernel();  // null if this machine or this build has none

}  // namespace spheretree::runtime
