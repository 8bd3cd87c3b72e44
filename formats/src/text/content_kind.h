// SPDX-License-Identifier: Apache-2.0
// Identifies the content of a file by its first bytes, for readers and for messages about an unexpected kind of file.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace spheretree::formats {

enum class MeshKind { Obj, Stl, Ply, Off, Gltf };

/// The kind that the content identifies with certainty; empty for a binary STL.
std::optional<MeshKind> meshKindOf(std::span<const char> bytes);

/// A binary STL has no magic number, but its size: 80 arbitrary bytes, the number of triangles, and 50 bytes for each.
bool hasSizeOfBinaryStl(std::span<const char> bytes);

/// "OBJ", "STL", "PLY", "OFF", "glTF".
const char* nameOf(MeshKind kind);

/// "a mesh (OBJ)", "a sphere-tree (.stree)", "a picture (PNG)", "a table (CSV)", "JSON", "empty"; "" for unknown
/// content.
std::string describedContent(std::string_view bytes);

}  // namespace spheretree::formats
