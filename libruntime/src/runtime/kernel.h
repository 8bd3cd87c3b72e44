// SPDX-License-Identifier: Apache-2.0
// The inner loops, compiled once for each instruction set from one source (kernel_lanes.h). All give the same bits: the same IEEE
// operations in the same order, no contraction.
#pragma once

#include <array>
#include <cstdint>

#include "spheretree/runtime/scene.h"

namespace spheretree::runtime {

struct TreeView {
  const Block* bound;
  const std::uint16_t* child_block;
  const std::uint8_t* inner_lanes;
};

/// Decides in double a pair that float cannot decide. Null `tool`: no pair is in doubt.
struct ExactTest {
  const std::array<double, 3>* tool = nullptr;    // (slot) about the reference point, tool axes
  const std::array<double, 3>* object = nullptr;  // (slot) world axes, about the anchor
  double rotation[9];                             // tool axes to world axes, row-major
  double offset[3];                               // reference point from the anchor
  double margin;
};

struct PairSearch {
  TreeView tool, object;       // the tool as it stands in the scene
  float rotation[9];           // tool axes to world axes, row-major
  Block* turned_tool;          // a block is turned when it is first met
  std::uint32_t* turned_when;  // (block) the `now` of its last turn
  std::uint32_t now;           // names the pose
  float offset[3];             // reference point from the anchor, world axes [mm]
  float inner_margin;          // the margin and all that rounding can lose
  float sure_margin;           // pairs of leaves within this are in, in float
  float maybe_margin;          // beyond this they are out; between, the exact test decides
  ExactTest exact;
  std::uint32_t* pairs;     // output; written to [0, capacity + 8)
  std::uint32_t* lists[2];  // each capacity + 8
  std::uint32_t capacity;   // >= 64
  std::uint32_t max_work;
};

struct PairSearchResult {
  std::uint32_t count, work;
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

struct WorstRow {
  std::uint32_t row;  // lowest index among equals
  float slack;        // a . y - b
};

struct KernelTable {
  PairSearchResult (*findPairs)(const PairSearch&);
  float (*makeRows)(const RowRequest&);                                                              // returns the smallest gap
  WorstRow (*worstRow)(const float* const* a, const float* b, std::uint32_t count, const float* y);  // count > 0
};

const KernelTable& scalarKernel();
const KernelTable* avx2Kernel();  // null if this machine or this build has none

}  // namespace spheretree::runtime
