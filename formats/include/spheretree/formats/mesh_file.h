// SPDX-License-Identifier: Apache-2.0
// Mesh file -> TriangleMesh in millimetres: OBJ, STL, PLY, OFF, glTF and GLB. What is read and what is refused:
// docs/mesh_input.md
// Deterministic: same file, same mesh. Nothing is repaired here, only welded: corners at exactly equal positions become
// one vertex, vertices that no triangle uses are left out, polygons are cut into triangles. Order is that of the file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "spheretree/core/mesh_edit.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::formats {

struct MeshFile {
  TriangleMesh mesh;  // [mm]; at least one triangle, every coordinate finite
  std::vector<std::uint32_t>
      vertex_of_file;  // vertex of `mesh` for each vertex in the order of the file; kNoVertex (core/mesh_edit.h): no face uses it
  double unit_mm = 1;  // one unit of the file [mm]
  std::string format;  // "OBJ", "STL (ASCII)", "STL (binary)", "PLY (ASCII)", ..., "glTF", "GLB"
  std::vector<std::string> notes;  // what a user may want to know: what was ignored, cut or doubtful; plain sentences
};

/// Reads by content where the extension is wrong, else by extension (any case).
/// `unit_mm`, `gltf_unit_mm`: one unit of an OBJ, STL, PLY or OFF file, and of a glTF file [mm], finite, > 0. glTF says
/// metres.
/// Cost: O(size of the file); memory at most some ten times the file.
/// @throws FileError if the file, or a buffer that a .gltf names, cannot be opened or read.
/// @throws FormatError if its content is refused; the message names the line or face, the value and what to do.
/// @throws std::invalid_argument for a unit that is not finite or not positive.
MeshFile readMesh(const std::filesystem::path& path, double unit_mm = 1.0, double gltf_unit_mm = 1000.0);

/// One cm, m or in [mm]; 1 for mm and for no unit ("").
double unitInMm(std::string_view unit);

/// The triangles of one part and their vertices, in the same order.
/// @throws FormatError if no part has this name; the message lists those there are.
TriangleMesh selectPart(const TriangleMesh& mesh, std::string_view name);

}  // namespace spheretree::formats
