// SPDX-License-Identifier: Apache-2.0
// A primitive that is compressed by Draco.
// Specification: Khronos, glTF extension KHR_draco_mesh_compression; Draco bitstream 2.2.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "mesh/mesh_assembly.h"

namespace spheretree::formats {

struct DracoAttribute {
  std::uint64_t component = 0;       // gltf_component.h: kFloat32, kUint8, ...
  std::size_t components = 0;        // numbers for each vertex, 1 to 4
  bool is_normalised = false;        // integers represent 0..1 or -1..1
  std::vector<unsigned char> bytes;  // little-endian, tightly packed; one element for each vertex
};

struct DracoMesh {
  std::uint64_t vertex_count = 0;
  std::vector<std::uint32_t> corners;      // three for each triangle, each below vertex_count
  std::vector<DracoAttribute> attributes;  // the requested ones, in that order
};

/// Decodes the attributes with these ids. The announced sizes are refused before memory is allocated if they exceed 64
/// triangles a byte (65,536 for small data), or `max_triangles`.
/// @param where The primitive, for messages.
/// @throws FormatError for invalid data, or a missing attribute.
DracoMesh decodeDraco(std::span<const unsigned char> bytes, std::span<const std::uint64_t> attribute_ids, std::uint64_t max_triangles,
                      const MeshAssembly& assembly, const std::string& where);

}  // namespace spheretree::formats
