// SPDX-License-Identifier: Apache-2.0
// Mesh file -> TriangleMesh in millimetres: OBJ, STL, PLY, OFF, glTF and GLB. Accepted and refused content:
// docs/mesh_input.md
// Deterministic: same file, same mesh. Nothing is repaired here; the reader only merges corners at exactly equal
// positions into one vertex, leaves out vertices that no triangle uses, and cuts polygons into triangles. The order of
// the file is kept.
#pragma once

#include <filesystem>
#include <string_view>

#include "spheretree/core/triangle_mesh.h"
#include "spheretree/formats/mesh_content.h"

namespace spheretree::formats {

/// Chooses the format by the extension (any case), or by the content if the extension is wrong.
/// `unit_mm`, `gltf_unit_mm`: one unit of an OBJ, STL, PLY or OFF file, and of a glTF file [mm], finite, > 0. glTF
/// prescribes metres.
/// Cost: O(size of the file); memory up to about ten times the size of the file.
/// @throws FileError if the file, or a buffer that a .gltf names, cannot be opened or read.
/// @throws FormatError if its content is refused; the message names the line or face, the value and what to do.
/// @throws std::invalid_argument for a unit that is not finite or not positive.
MeshFile readMesh(const std::filesystem::path& path, double unit_mm = 1.0, double gltf_unit_mm = 1000.0);

/// The length of one cm, m or in [mm]; 1 for mm and for "" (no unit).
double unitInMm(std::string_view unit);

/// The triangles of one part and their vertices, in the same order.
/// @throws FormatError if no part has this name; the message lists the existing names.
TriangleMesh selectPart(const TriangleMesh& mesh, std::string_view name);

}  // namespace spheretree::formats
