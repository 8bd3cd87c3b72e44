// SPDX-License-Identifier: Apache-2.0
// A skin (core/skin.h) laid out for the inner loops: a search tree over its triangles, and a record of 128 bytes for each of them, which
// eight lanes load and transpose.
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
  float allowance;             // the flat triangle gives way by this, so that the patch is what is felt; 0: the patch is flat [mm]
  std::uint32_t sharp;         // bit k: side k is sharp
  float unused[3];
};
static_assert(sizeof(CompiledPatch) == 128);

struct CompiledSkin {
  CompiledTree tree;                 // its items are the triangles
  std::vector<CompiledPatch> patch;  // (triangle)
  float tolerance = 0;               // no allowance is larger [mm]
  bool empty() const { return patch.empty(); }
};

/// `origin` of the skin's frame less the centre that the compiled skin is about.
CompiledSkin compileSkin(const Skin& skin, const Eigen::Vector3d& origin);

}  // namespace spheretree::runtime
