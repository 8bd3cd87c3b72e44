// SPDX-License-Identifier: Apache-2.0
// The inner loops over a block of what is cut, for each instruction set.
#pragma once

#include <cstddef>
#include <cstdint>

#include "scene/compiled_skin.h"

namespace spheretree::runtime {

inline constexpr std::size_t kBlockPoints = 512;  // of a block of what is cut: 8 x 8 x 8, x varies fastest, then y

/// Removes what a ball sweeps on a straight way from a block of points.
struct CutRequest {
  float corner[3];                        // first point of the block, from the start of the way [mm]
  float way[3];                           // [mm]
  float inverse_square, radius, spacing;  // 1 / |way|^2, or 0; of the ball; of the points
  float* clearance;                       // (point) distance to what was removed
  float* row_most;                        // (row of 8 points) largest clearance
  std::uint8_t* wall;                     // (row) bits of the points about which the wall has balls
  const float* depth;                     // (point) below the surface
  const std::uint8_t* layer;              // (point)
  double* volume;                         // (layer) what is removed is added [mm^3]
  float largest, play;                    // clearance of the middle of a ball of the wall; its distance from what was removed
};

/// Which balls of the wall in a block come within reach of a point.
struct WallRequest {
  float corner[3];                      // first point of the block, from the point [mm]
  float spacing, reach, largest, play;  // of the points; of the point; radius of the largest ball; as above
  const float* clearance;
  const float* depth;
  const std::uint8_t* wall;
  std::uint8_t* near;  // (row) bits of the points about which they lie; a few that are as near as rounding, too
};

/// Distances of a block of points from triangles, positive behind the nearest one.
struct DepthRequest {
  double corner[3];      // as the triangles
  float spacing, reach;  // of the points; no distance is larger
  const CompiledPatch* patches;
  const std::uint32_t* triangles;
  std::uint32_t count;
  float* out;  // (point)
};

/// Both tables give the same bits.
struct CutKernel {
  void (*cutBlock)(const CutRequest&);
  void (*nearWalls)(const WallRequest&);
  void (*signedDistances)(const DepthRequest&);
};

const CutKernel& scalarCutKernel();
const CutKernel& avx2CutKernel();  // only if avx2Kernel() is not null

}  // namespace spheretree::runtime
