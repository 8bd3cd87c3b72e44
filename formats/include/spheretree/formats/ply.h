// SPDX-License-Identifier: Apache-2.0
// PLY 1.0: ASCII, little and big endian, any scalar types, other elements and properties skipped. One part.
#pragma once

#include <span>
#include <string>

#include "spheretree/formats/mesh_file.h"

namespace spheretree::formats {

/// `name` stands for the file in messages; `unit_mm`: one unit of the file [mm], finite, > 0.
/// Cost: O(size). @throws FormatError, std::invalid_argument as readMesh does.
MeshFile readPly(std::span<const char> bytes, const std::string& name, double unit_mm = 1.0);

}  // namespace spheretree::formats
