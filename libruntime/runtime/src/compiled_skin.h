// SPDX-License-Identifier: Apache-2.0
// A skin (core/skin.h) laid out for the inner loops: a search tree over its triangles, and a record of 112 bytes for
// each of them, which eight lanes load and transpose.
// Units: mm; frame: axes of the file, about the centre of the object.
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
  std::uint32_t flags;         // bit k: side k is sharp; kCurved; from kSwingShift and kLeanShift on: how curved it is at most
};
static_assert(sizeof(CompiledPatch) == 112);
inline constexpr std::uint32_t kCurved = 8;  // the flat triangle gives way by the tolerance, so that the patch is what is felt

// How far a patch swings out of its flat triangle, in parts of what curved triangles give way, and the sine of the
// angle by which its normals lean from that of the triangle; both rounded up.
inline constexpr int kSwingShift = 8;
inline constexpr int kLeanShift = 24;
inline constexpr std::uint32_t kSwingMask = 0xffff;
inline constexpr std::uint32_t kLeanMask = 0xff;

struct CompiledSkin {
  CompiledTree tree;                 // its items are the triangles
  std::vector<CompiledPatch> patch;  // (triangle)
  float tolerance = 0;               // what triangles with a curved patch give way [mm]
  bool empty() const { return patch.empty(); }
};

inline constexpr float kSwingOfOffset = 4.0f / 3.0f * (1 + 1e-6f);  // how far a patch swings out for each 1 of the largest offset of a side

/// The record of one patch, moved by `shift`. `swing`: how far it is from its flat triangle at most; `allowance`: what
/// its triangle gives way if it is curved, no less [mm]. Normals are of unit length.
CompiledPatch compilePatch(const SkinPatch& patch, const Eigen::Vector3f& shift, float swing, float allowance);

/// `origin` of the skin's frame less the centre that the compiled skin is about.
CompiledSkin compileSkin(const Skin& skin, const Eigen::Vector3d& origin);

}  // namespace spheretree::runtime
