// SPDX-License-Identifier: Apache-2.0
// PLY 1.0: ASCII, little and big endian, any scalar types, other elements and properties skipped. One part.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "spheretree/formats/mesh_content.h"

namespace spheretree::formats {

/// `name` is the name of the file in messages; `unit_mm`: one unit of the file [mm], finite, > 0.
/// Cost: O(size). @throws FormatError, std::invalid_argument as readMesh does.
MeshFile readPly(std::span<const char> bytes, const std::string& name, double unit_mm = 1.0);

/// One number for each vertex or face, in the order of the file.
struct PlyColumn {
  bool is_of_faces = false;
  std::vector<double> values;
};

/// The scalar properties of this name, of the vertices, then of the faces; "colour" is 65536 red + 256 green + blue.
/// @throws FormatError as readPly(), and if there is no such property; the message lists the existing ones.
std::vector<PlyColumn> readPlyColumns(std::span<const char> bytes, const std::string& name, const std::string& property);

}  // namespace spheretree::formats
