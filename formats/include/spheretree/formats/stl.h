// SPDX-License-Identifier: Apache-2.0
// STL, ASCII and binary, distinguished by size: a file of exactly 84 + 50 n bytes with n in its header is binary,
// whatever its first bytes. Normals and attributes are ignored, also attributes whose two bytes are their length;
// solids of an ASCII file are parts.
#pragma once

#include <span>
#include <string>

#include "spheretree/formats/mesh_content.h"

namespace spheretree::formats {

/// `name` is the name of the file in messages; `unit_mm`: one unit of the file [mm], finite, > 0.
/// Cost: O(size). @throws FormatError, std::invalid_argument as readMesh does.
MeshFile readStl(std::span<const char> bytes, const std::string& name, double unit_mm = 1.0);

}  // namespace spheretree::formats
