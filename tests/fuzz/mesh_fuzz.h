// SPDX-License-Identifier: Apache-2.0
// The promise of every mesh reader for any bytes: a message that names the file, or a complete mesh.
#pragma once

#include <algorithm>
#include <span>
#include <string>

#include "fuzz/fuzz_target.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/mesh_file.h"

namespace spheretree::fuzz {

template <class Read>
void feedMesh(const std::uint8_t* data, std::size_t size, Read&& read) {
  formats::MeshFile file;
  try {
    file = read(std::span<const char>(reinterpret_cast<const char*>(data), size), std::string("fuzz"));
  } catch (const formats::FormatError& error) {
    require(std::string(error.what()).starts_with("fuzz: "), "a refusal names the file");
    return;
  }
  const TriangleMesh& mesh = file.mesh;
  require(!mesh.triangles.empty(), "an accepted mesh has a triangle");
  require(mesh.part.empty() ? mesh.part_names.empty() : mesh.part.size() == mesh.triangles.size(), "each triangle has a part, or none");
  for (const std::uint32_t part : mesh.part) require(part < mesh.part_names.size(), "each part has a name");
  std::vector<bool> used(mesh.positions.size());
  for (const Triangle& triangle : mesh.triangles)
    for (const std::uint32_t v : triangle) {
      require(v < mesh.positions.size(), "a triangle names a vertex that exists");
      used[v] = true;
    }
  for (std::size_t v = 0; v < used.size(); ++v) require(used[v] && mesh.positions[v].allFinite(), "each vertex is finite and in use");
  require(mesh.triangles.size() <= std::max<std::size_t>(4'000'000, size), "the mesh is in proportion to the file");
}

}  // namespace spheretree::fuzz
