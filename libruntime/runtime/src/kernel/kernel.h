// SPDX-License-Identifier: Apache-2.0
// The inner loops, compiled once for each instruction set from one source (kernel_lanes.h and what it includes). All
// give the same bits: the same IEEE operations in the same order, no contraction.
#pragma once

#include <array>
#include <cstdint>

#include "scene/compiled_hulls.h"
#include "scene/compiled_skin.h"
#include "scene/compiled_tree.h"

namespace spheretree::runtime {

/// The point where a ball was last taken to touch a soft patch, and the normal there.
struct SoftPoint {
  float u, v;                // weights of corners 1 and 2
  float normal[3];           // axes of the object
  std::uint32_t pair = ~0u;  // as in RowRequest
  std::uint32_t step = 0;    // step in which they were found
  std::uint32_t stuck = 0;   // last step in which the ball stuck to the point; in the next step it is still there
};

// A cache of them: kPointSets sets of kPointWays points each.
inline constexpr std::uint32_t kPointSets = 1024, kPointWays = 4;

/// The point of a pair in the cache; if it is not there, the one to replace: the oldest of its set.
inline SoftPoint& pointOf(SoftPoint* points, std::uint32_t pair) {
  SoftPoint* const set = points + kPointWays * ((pair * 0x9e3779b1u >> 16) % kPointSets);
  SoftPoint* oldest = set;
  for (SoftPoint* p = set; p < set + kPointWays; ++p) {
    if (p->pair == pair) return *p;
    if (p->step < oldest->step) oldest = p;
  }
  return *oldest;
}

/// An object for the search and the rows: the data that they read before the blocks. `patches` is null if the tool
/// rests on leaves.
struct alignas(64) ObjectView {
  const Block* bound;
  const BlockLinks* links;
  const std::array<double, 3>* exact;  // (slot) relative to the anchor, axes of the object
  const double* anchor;                // world frame
  const Sphere* spheres;               // (slot) may be null
  const CompiledPatch* patches;        // (triangle)
  const std::uint32_t* items;          // (slot) triangle
  const CompiledPatch* still_patches;  // the same if they stay where they are; else null: the search then tests their balls alone
  float allowance;                     // triangles with a curved patch yield by this [mm]
  float motion;                        // of tissue: how much farther than the margin the search looks [mm]
  float behind;        // a ball at most this far behind a triangle is pushed out in front of it; 0: triangles have two sides [mm]
  float* in_front;     // of tissue: (tool slot) distance of the ball's centre from the nearest triangle that it is in front of [mm]
  SoftPoint* points;   // of tissue: the cache of them
  std::uint32_t step;  // of tissue: points found in this step stay
  double to_world[9];  // axes of the object to world axes, row-major
};

/// Pose of the tool in the axes of an object.
struct RelativePose {
  float rotation[9];  // tool axes to those of the object, row-major
  float offset[3];    // reference point of the tool from the anchor [mm]
};

/// Up to 8 pairs that one test found: one node of the tool or of an object, and some lanes of a block of the other
/// tree.
struct HitGroup {
  std::uint32_t pair;             // of lane 0: tool slot << 16 | object slot
  std::uint32_t open_block : 16;  // next block to test on the side being opened; on the side of the lanes: that of lane 0's children
  std::uint32_t lanes : 8;        // bit k: lane k was hit
  std::uint32_t tool_varies : 1;  // the lanes are slots of the tool, not of the object
};

/// What a hull of the tool has beside its first ball (CompiledHulls); null for a tool of balls alone.
struct HullSpans {
  const Sphere *span1, *span2, *turn0, *turn1;
  const std::array<float, 2>* swell;
  const float* bend;
  const std::uint32_t* way;
};
inline HullSpans spansOf(const CompiledHulls& hulls) {
  return {hulls.span1.data(), hulls.span2.data(), hulls.turn0.data(), hulls.turn1.data(),
          hulls.swell.data(), hulls.bend.data(),  hulls.way.data()};
}

struct PairSearch {
  const Block *tool, *object_roots;
  const BlockLinks* tool_links;
  const std::array<double, 3>* exact_tool;  // (slot) relative to the reference point, tool axes
  HullSpans hulls;
  const Sphere* hull_balls;  // (slot of a way) ball 0
  const ObjectView* objects;
  std::uint32_t object_count, near_count;
  double rotation[9];           // tool axes to world axes, row-major
  double position[3];           // of the reference point, world frame
  double margin;                // [mm]
  float root[4];                // bounding sphere of the tool in the world; its radius includes all margins of the broad phase
  float inner_margin;           // the margin plus all rounding errors; pairs beyond it are excluded
  float sure_margin;            // pairs of items within this distance in float are included; beyond it double arithmetic decides
  Block* turned_tool;           // scratch: a block is rotated to the axes of an object when it is first needed
  std::uint32_t* turned_when;   // (block) the `turn_count` of its last rotation
  std::uint32_t turn_count;     // number of searches of objects before this search
  std::uint32_t* near_objects;  // output; [0, object_count + 8)
  HitGroup *leaves, *open_tool, *open_object;  // scratch, list_capacity each
  std::uint32_t* pairs;                        // output; [0, capacity + 8), by object
  std::uint32_t* near_counts;                  // output: pairs of each near object
  std::uint32_t capacity, list_capacity, max_work;
};

struct PairSearchResult {
  std::uint32_t count, work;
  bool coarse;
};

/// Rows of pairs of one object.
struct RowRequest {
  const std::uint32_t* pairs;  // tool slot << 16 | object slot
  std::uint32_t count;
  const Sphere* tool;  // (slot) relative to the reference point, tool axes; of a hull: ball 0, by the slot of a way
  HullSpans hulls;
  RelativePose pose;             // of the tool in the axes of the object
  float to_world[9];             // axes of the object to world axes, row-major
  const Block* bound;            // of the object
  const Sphere* object;          // (slot) the same spheres; null: only the blocks have them
  const CompiledPatch* patches;  // (triangle); null: rows are made with the object's spheres
  const std::uint32_t* items;    // (slot) triangle
  SoftPoint* points;             // as in the view
  std::uint32_t step;
  float inverse_angle_length;
  float max_gap;    // of felt rows: the plane beside a patch gives a row only up to this gap, otherwise a row that is always satisfied [mm]
  float allowance;  // triangles with a curved patch yield by this [mm]
  float behind;     // as in the view; less for a ball that is in front of a nearer triangle
  float* in_front;  // as in the view; null if `behind` is 0
  bool squared;     // RowForm::SquaredDistance, of spheres
  float axes[9];    // row k: the axis of angle k; used if `squared`
  float* a[6];      // output [0, count + 8), as are the following arrays
  float* b;
  float* weight;
  float* along;     // of a tool of hulls, else null: where the touched point is along the normal, from the reference point [mm]
  float* felt_way;  // of flat triangles: lower bound of the way on which the ball touches the patch [mm]; infinite if the patch is flat
};

/// What the ways of pairs of hulls and the triangles of a skin are found from.
struct HullWays {
  const std::uint8_t* ways;  // CompiledSkin::ways
  std::uint32_t apart;       // CompiledHulls::ways_apart
  float reach;               // parts that are farther than this from the triangle touch it in no way [mm]
  float turn;                // the tool turns by at most this before the next search [rad]
  std::uint32_t* to;         // output: pairs with a way each; [0, three times the number of pairs + 8)
};

struct WorstRow {
  std::uint32_t row;  // lowest index among equals
  float slack;        // a . y - b
};

struct KernelTable {
  std::uint32_t (*findNear)(const PairSearch&);                     // lists the objects whose bounding spheres touch that of the tool
  PairSearchResult (*findPairs)(const PairSearch&);                 // among these near objects
  std::uint32_t (*spreadWays)(const RowRequest&, const HullWays&);  // returns the number of pairs with a way each
  float (*sphereRows)(const RowRequest&);                           // ball and ball; returns the smallest gap
  float (*flatRows)(const RowRequest&);  // ball, reduced by the allowance, and flat triangle; returns the smallest gap
  std::uint32_t (*keepResting)(const RowRequest&, std::uint32_t* pairs);  // in place those of hulls that may rest on their patch
  float (*feltRows)(const RowRequest&);  // ball and patch; always satisfied if the ball does not rest on this patch
  WorstRow (*worstRow)(const float* const* a, const float* b, std::uint32_t count, const float* y);  // count > 0
};

RelativePose relativePose(const ObjectView& object, const double rotation[9], const double position[3]);

const KernelTable& scalarKernel();
const KernelTable* avx2Kernel();  // null if this machine or this build does not have it; slow: asks the processor

}  // namespace spheretree::runtime
