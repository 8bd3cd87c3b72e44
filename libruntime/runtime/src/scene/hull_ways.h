// SPDX-License-Identifier: Apache-2.0
// The ways in which hulls of a tool may touch the triangles of a skin. docs/algorithms/runtime/hull_rows.md
#pragma once

#include <cstdint>
#include <vector>

#include "scene/compiled_skin.h"

namespace spheretree::runtime {

/// (triangle) The ways that the guarantee needs: bits 0 .. 2 for the sides at which a cone may touch it, bits 3 .. 5
/// for the corners at which a slab may. A touch that a neighbour answers for, or that the shape of the object rules
/// out, is no way. Sets, in the flags of `patches`, which way has the felt row of the smooth patch, in which both rest
/// wherever their normals agree. Cost: about 250 ns a triangle.
std::vector<std::uint8_t> hullWays(const Skin& skin, std::vector<CompiledPatch>& patches);

}  // namespace spheretree::runtime
