// SPDX-License-Identifier: Apache-2.0
// Wavefront OBJ: vertices and polygons. An object and a group (`o`, `g`) together are a part; in a file without these,
// or with only one, a material (`usemtl`) is. Normals, texture coordinates, lines, points and free-form surfaces are
// ignored.
#pragma once

#include <span>
#include <string>

#include "spheretree/formats/mesh_content.h"

namespace spheretree::formats {

/// `name` is the name of the file in messages; `unit_mm`: one unit of the file [mm], finite, > 0.
/// Cost: O(size). @throws FormatError, std::invalid_argument as readMesh does.
MeshFile readObj(std::span<const char> text, const std::string& name, double unit_mm = 1.0);

}  // namespace spheretree::formats
