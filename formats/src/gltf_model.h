// SPDX-License-Identifier: Apache-2.0
// A glTF or GLB file as tinygltf's model, checked beforehand so that any bytes are safe.
#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "mesh_assembly.h"

namespace spheretree::formats {

enum Component : std::uint64_t { kInt8 = 5120, kUint8 = 5121, kInt16 = 5122, kUint16 = 5123, kUint32 = 5125, kFloat32 = 5126 };

/// Optional extensions of a bufferView beside which its own bytes are a fallback.
inline constexpr const char* kCompressedViews[] = {"EXT_meshopt_compression", "KHR_meshopt_compression"};

bool isGlb(std::span<const char> bytes);
std::string place(const std::string& key, std::uint64_t index);  // "meshes[3]"
/// Says what is wrong with an element, as "meshes[3].primitives[0]".
[[noreturn]] void refuseElement(const MeshAssembly& assembly, const std::string& where, const std::string& what);

/// Holds the nodes, the scene to read, the meshes that nodes name with their triangles and positions, and the
/// accessors, bufferViews and buffers of those. All else keeps its index, but is empty. Certain: every index is within
/// its array; accessors have an element, the type and a componentType of their use, and a bufferView if they hold
/// indices; transforms have all their numbers; buffers have all their bytes. Not certain: that views lie within
/// buffers, and accessors within views. Cost: O(bytes) in time and memory, and of the buffers beside.
/// @param folder Buffers in files lie in it or below; empty: none are read.
/// @throws FormatError for what is not such a file; FileError for a buffer that cannot be read.
tinygltf::Model loadGltfModel(std::span<const char> bytes, const std::filesystem::path& folder, MeshAssembly& assembly);

}  // namespace spheretree::formats
