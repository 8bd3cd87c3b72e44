// SPDX-License-Identifier: Apache-2.0
// What every mesh reader returns.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "spheretree/core/mesh_edit.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::formats {

struct MeshFile {
  TriangleMesh mesh;  // [mm]; at least one triangle, every coordinate finite
  std::vector<std::uint32_t>
      vertex_of_file;  // vertex of `mesh` for each vertex of the file, in its order; kNone (core/mesh_edit.h) if no face uses it
  std::vector<std::uint32_t> face_of_triangle;  // of `mesh`: index of the face of the file from which it was cut
  std::vector<std::array<std::uint8_t, 3>>
      colours;                     // of each triangle: red, green, blue (sRGB); empty unless materials (glTF) give several
  std::size_t faces = 0;           // number of faces in the file, with those that were left out
  double unit_mm = 1;              // one unit of the file [mm]
  std::string space;               // "LPS" or "RAS" if the header says which way the axes of the patient point; else ""
  std::string format;              // "OBJ", "STL (ASCII)", "STL (binary)", "PLY (ASCII)", ..., "glTF", "GLB"
  std::vector<std::string> notes;  // what was ignored, cut or doubtful; whole sentences for the user
};

}  // namespace spheretree::formats
