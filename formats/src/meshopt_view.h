// SPDX-License-Identifier: Apache-2.0
// A bufferView that was compressed by meshoptimizer.
// Specification: Khronos, glTF extension EXT_meshopt_compression, which is KHR_meshopt_compression of codec version 0.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "mesh_assembly.h"

namespace spheretree::formats {

struct MeshoptView {
  std::span<const unsigned char> bytes;  // compressed
  std::uint64_t count = 0;               // elements
  std::uint64_t stride = 0;              // of an element [bytes]
  std::string mode;                      // "ATTRIBUTES", "TRIANGLES", "INDICES"
  std::string filter;                    // "NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"
};

/// `count * stride` bytes. What is announced is compared with what so few compressed bytes can hold, at most 64 for
/// one, before memory is taken.
/// @param where The view, for messages.
/// @throws FormatError for anything that the specification does not allow, or that does not unpack to its size.
std::vector<unsigned char> decodeMeshopt(const MeshoptView& view, const MeshAssembly& assembly, const std::string& where);

}  // namespace spheretree::formats
