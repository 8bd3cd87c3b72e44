// SPDX-License-Identifier: Apache-2.0
// The inner loops, compiled once for each instruction set from one source (kernel_lanes.h). All give the same bits: the
// same IEEE operations in the same order, no contraction.
#pragma once

#include <array>
#include <cstdint>

#include "compiled_skin.h"
#include "compiled_tree.h"

namespace spheretree::runtime {

/// Where on a soft patch a ball was last taken to touch it, and with which normal.
struct SoftPoint {
  float u, v;          // weights of corners 1 and 2
  float normal[3];     // axes of the object
  std::uint32_t tool;  // slot of the ball
  std::uint32_t step;  // in which it stays there
};

/// An object as the search and the rows see it: what they read of it before the blocks. `patches` is null where leaves
/// are felt.
struct alignas(64) ObjectView {
  const Block* bound;
  const BlockLinks* links;
  const std::array<double, 3>* exact;  // (slot) about the anchor, axes of the object
  const double* anchor;                // world
  const Sphere* spheres;               // (slot) may be null
  const CompiledPatch* patches;        // (triangle)
  const std::uint32_t* items;          // (slot) triangle
  float allowance;                     // what triangles with a curved patch give way [mm]
  float motion;                        // no point of it moves farther in a step, its body apart [mm]
  float behind;                        // so far behind a triangle of it a ball is pushed out in front; 0: triangles have two sides [mm]
  SoftPoint* points;                   // (slot) of tissue
  std::uint32_t step;                  // of tissue: the points of this step stay
  bool is_found;                       // of tissue: points that are found now stay for the step
  double to_world[9];                  // axes of the object to world axes, row-major
};

/// Where the tool is in the axes of an object.
struct RelativePose {
  float rotation[9];  // tool axes to those of the object, row-major
  float offset[3];    // reference point of the tool from the anchor [mm]
};

/// Up to 8 pairs that one test found: one node of the tool or of an object, and some lanes of a block of the other
/// side.
struct HitGroup {
  std::uint32_t pair;             // of lane 0: tool slot << 16 | object slot
  std::uint32_t open_block : 16;  // next block to test on the side being opened; on the side of the lanes: that of lane 0's children
  std::uint32_t lanes : 8;        // bit k: lane k was hit
  std::uint32_t tool_varies : 1;  // the lanes are slots of the tool, not of the object
};

struct PairSearch {
  const Block *tool, *object_roots;
  const BlockLinks* tool_links;
  const std::array<double, 3>* exact_tool;  // (slot) about the reference point, tool axes
  const ObjectView* objects;
  std::uint32_t object_count;
  double rotation[9];                          // tool axes to world axes, row-major
  double position[3];                          // of the reference point, world
  double margin;                               // [mm]
  float root[4];                               // bounding sphere of the tool in the world, radius with all that the broad phase adds
  float inner_margin;                          // the margin and all that rounding can lose; beyond it no pair is in
  float sure_margin;                           // pairs of items within this are in, in float; between, double decides
  Block* turned_tool;                          // a block is turned into the axes of an object when it is first met there
  std::uint32_t* turned_when;                  // (block) the `turn_count` of its last turn
  std::uint32_t turn_count;                    // of the searches of objects before this search
  std::uint32_t* near_objects;                 // output; [0, object_count + 8)
  HitGroup *leaves, *open_tool, *open_object;  // scratch, list_capacity each
  std::uint32_t* pairs;                        // output; [0, capacity + 8), by object
  std::uint32_t* near_counts;                  // output: pairs of each near object
  std::uint32_t capacity, list_capacity, max_work;
};

struct PairSearchResult {
  std::uint32_t count, near_count, work;
  bool coarse;
};

/// Rows of pairs of one object.
struct RowRequest {
  const std::uint32_t* pairs;  // tool slot << 16 | object slot
  std::uint32_t count;
  const Sphere* tool;            // (slot) about the reference point, tool axes
  RelativePose pose;             // of the tool in the axes of the object
  float to_world[9];             // axes of the object to world axes, row-major
  const Block* bound;            // of the object
  const Sphere* object;          // (slot) the same spheres; null: only those of the blocks are kept
  const CompiledPatch* patches;  // (triangle); null: the object's spheres are met
  const std::uint32_t* items;    // (slot) triangle
  SoftPoint* points;             // as in the view
  std::uint32_t step;
  bool is_found;
  float inverse_angle_length;
  float most_gap;   // of felt rows: a plane beside the patch that is farther off gives a row that is always satisfied [mm]
  float allowance;  // what triangles with a curved patch give way [mm]
  float behind;     // as in the view
  bool squared;     // RowForm::SquaredDistance, of spheres
  float axes[9];    // row k: the axis of angle k; used if `squared`
  float* a[6];      // written to [0, count + 8), as are the following
  float* b;
  float* weight;
  float* felt_way;  // of flat triangles: the ball touches the patch on no shorter way [mm]; infinite where it is flat
};

struct WorstRow {
  std::uint32_t row;  // lowest index among equals
  float slack;        // a . y - b
};

struct KernelTable {
  PairSearchResult (*findPairs)(const PairSearch&);
  float (*sphereRows)(const RowRequest&);  // ball and ball; returns the smallest gap
  float (*flatRows)(const RowRequest&);    // ball, less what the patch gives way, and flat triangle; returns the smallest gap
  float (*feltRows)(const RowRequest&);    // ball and patch; always satisfied where the patch is not what holds the ball
  WorstRow (*worstRow)(const float* const* a, const float* b, std::uint32_t count, const float* y);  // count > 0
};

RelativePose relativePose(const ObjectView& object, const double rotation[9], const double position[3]);

const KernelTable& scalarKernel();
const KernelTable* avx2Kernel();  // null if this machine or this build has none

}  // namespace spheretree::runtime
