// SPDX-License-Identifier: Apache-2.0
// A skin (core/skin.h) in the memory layout of the inner loops: a search tree over its triangles, and a record of 112
// bytes for each of them, which eight lanes load and transpose.
// Units: mm; frame: axes of the file, origin at the centre of the object.
#pragma once

#include <cstdint>
#include <vector>

#include "compiled_tree.h"
#include "spheretree/core/skin.h"

namespace spheretree::runtime {

inline constexpr float kNormalScale = 32767;  // of the components of unit vectors in 16 bits

/// Nodes: corners 0, 1, 2, then the middles of the sides 01, 12, 20.
struct CompiledPatch {
  float position[6][3];
  std::uint16_t normal[6][3];  // two's complement, times kNormalScale
  std::uint32_t flags;         // bit k: side k is sharp; kCurved; from bit kSwingShift and kLeanShift: upper bounds of how curved it is
};
static_assert(sizeof(CompiledPatch) == 112);
inline constexpr std::uint32_t kCurved = 8;  // the flat triangle yields by the tolerance, so that the tool rests on the patch

// The swing of a patch out of its flat triangle, as a share of the allowance of curved triangles, and the sine of the
// largest angle between its normals and that of the triangle; both rounded up.
inline constexpr int kSwingShift = 8;
inline constexpr int kLeanShift = 24;
inline constexpr std::uint32_t kSwingMask = 0xffff;
inline constexpr std::uint32_t kLeanMask = 0xff;

struct CompiledSkin {
  CompiledTree tree;                 // its items are the triangles
  std::vector<CompiledPatch> patch;  // (triangle)
  float tolerance = 0;               // allowance of the triangles with a curved patch: they yield by this [mm]
  bool empty() const { return patch.empty(); }
};

inline constexpr float kSwingOfOffset = 4.0f / 3.0f * (1 + 1e-6f);  // swing of a patch, divided by the largest component of a side's offset

/// The record of one patch, translated by `shift`. `swing`: its largest distance from its flat triangle; `allowance`:
/// lower bound of how far its triangle yields if it is curved [mm]. Normals must be of unit length.
CompiledPatch compilePatch(const SkinPatch& patch, const Eigen::Vector3f& shift, float swing, float allowance);

/// `origin`: origin of the skin's frame minus the centre of the compiled skin.
CompiledSkin compileSkin(const Skin& skin, const Eigen::Vector3d& origin);

}  // namespace spheretree::runtime
