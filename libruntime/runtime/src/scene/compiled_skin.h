// SPDX-License-Identifier: Apache-2.0
// A skin (core/skin.h) in the memory layout of the inner loops: a search tree over its triangles, and a record of 112
// bytes for each of them, which eight lanes load and transpose.
// Units: mm; frame: axes of the file, origin at the centre of the object.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "scene/compiled_tree.h"
#include "spheretree/core/skin.h"

namespace spheretree::runtime {

inline constexpr float kNormalScale = 32767;  // of the components of unit vectors in 16 bits

/// Nodes: corners 0, 1, 2, then the middles of the sides 01, 12, 20.
struct CompiledPatch {
  float position[6][3];
  std::uint16_t normal[6][3];  // two's complement, times kNormalScale
  std::uint32_t flags;         // bit k: side k is sharp; kCurved; the other bits: see the shifts below
};
static_assert(sizeof(CompiledPatch) == 112);
inline constexpr std::uint32_t kCurved = 8;  // the flat triangle yields by the tolerance, so that the tool rests on the patch

// Of the ways in which a cone or a slab may touch the triangle (hull_ways.h), the one with the felt row of the smooth
// patch.
inline constexpr int kFeltConeShift = 4;
inline constexpr int kFeltSlabShift = 6;
inline constexpr std::uint32_t kNoFeltWay = 3;

// The swing of a patch out of its flat triangle, as a share of the allowance of curved triangles, and the sine of the
// largest angle between its normals and that of the triangle; both rounded up.
inline constexpr int kSwingShift = 8;
inline constexpr int kLeanShift = 24;
inline constexpr std::uint32_t kSwingMask = 0xffff;
inline constexpr std::uint32_t kLeanMask = 0xff;

/// The triangles below a node, as they are seen from afar: one small face.
struct FarFace {
  float area[3];    // sum of their area vectors [mm^2]
  float centre[3];  // mean of their centres, weighted by area
  float radius;     // of a ball about the centre that contains them
};

struct CompiledSkin {
  CompiledTree tree;                 // its items are the triangles
  std::vector<CompiledPatch> patch;  // (triangle)
  std::vector<FarFace> far;          // (block) of the triangles below the block
  std::vector<std::uint8_t> ways;    // (triangle) of hulls, hull_ways.h; empty for a tool of balls
  float tolerance = 0;               // allowance of the triangles with a curved patch: they yield by this [mm]
  bool empty() const { return patch.empty(); }
};

inline constexpr float kSwingOfOffset = 4.0f / 3.0f * (1 + 1e-6f);  // swing of a patch, divided by the largest component of a side's offset

using PackedDirection = std::array<std::uint16_t, 3>;  // as in CompiledPatch::normal
inline PackedDirection packed(const Eigen::Vector3f& unit) {
  const auto rounded = [](float scaled) {
    return static_cast<std::uint16_t>(static_cast<std::int16_t>(scaled + (scaled < 0 ? -0.5f : 0.5f)));
  };
  return {rounded(unit.x() * kNormalScale), rounded(unit.y() * kNormalScale), rounded(unit.z() * kNormalScale)};
}

/// Upper bound of the sine of the angle between normals of the patch, which must be of unit length, and that of its
/// flat triangle.
float leanOf(const PaddedPatch& patch);

// The bits of CompiledPatch::flags; the arguments are shares of 1, and are rounded up. NaN becomes the maximum.
inline std::uint32_t roundedUp(float part, std::uint32_t parts) {
  return part < 1 ? static_cast<std::uint32_t>(part * static_cast<float>(parts)) + 1 : parts;
}
inline std::uint32_t swingBits(float swing) { return roundedUp(swing, kSwingMask) << kSwingShift; }
inline std::uint32_t leanBits(float lean) { return roundedUp(lean, kLeanMask) << kLeanShift; }

/// The far faces of a tree over triangles.
std::vector<FarFace> farFaces(const CompiledTree& tree, std::span<const CompiledPatch> patches);

/// `origin`: origin of the skin's frame minus the centre of the compiled skin.
CompiledSkin compileSkin(const Skin& skin, const Eigen::Vector3d& origin);

}  // namespace spheretree::runtime
