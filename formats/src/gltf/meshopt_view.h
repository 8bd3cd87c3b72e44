// SPDX-License-Identifier: Apache-2.0
// A bufferView that is compressed by meshoptimizer.
// Specification: Khronos, glTF extension EXT_meshopt_compression, which is KHR_meshopt_compression of codec version 0.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "mesh/mesh_assembly.h"

namespace spheretree::formats {

struct MeshoptView {
  std::span<const unsigned char> bytes;  // compressed
  std::uint64_t count = 0;               // elements
  std::uint64_t stride = 0;              // size of an element [bytes]
  std::string mode;                      // "ATTRIBUTES", "TRIANGLES", "INDICES"
  std::string filter;                    // "NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"
};

/// Decodes `count * stride` bytes. Before memory is allocated, the announced size is compared with the largest possible
/// size, at most 64 times that of the compressed bytes.
/// @param where The view, for messages.
/// @throws FormatError for anything that violates the specification, or that does not decode to its size.
std::vector<unsigned char> decodeMeshopt(const MeshoptView& view, const MeshAssembly& assembly, const std::string& where);

}  // namespace spheretree::formats
