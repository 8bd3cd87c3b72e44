// SPDX-License-Identifier: Apache-2.0
// Writes a triangle mesh as PLY or OBJ, in millimetres, without loss.
#pragma once

#include <cstddef>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::formats {

/// Binary PLY, little-endian: positions as double, and triangles. Parts are not written.
std::vector<std::byte> encodePly(const TriangleMesh& mesh);

/// OBJ: positions as the shortest decimals that read back as the same double, and a group (g) for each part that has a
/// name.
std::vector<std::byte> encodeObj(const TriangleMesh& mesh);

}  // namespace spheretree::formats
