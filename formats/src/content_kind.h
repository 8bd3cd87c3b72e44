// SPDX-License-Identifier: Apache-2.0
// What a file holds, by its first bytes: for readers, and for messages about a file of another kind than was expected.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace spheretree::formats {

enum class MeshKind { Obj, Stl, Ply, Off, Gltf };

/// What the content says without doubt; nothing for a binary STL.
std::optional<MeshKind> meshKindOf(std::span<const char> bytes);

/// A binary STL has no mark, but says how many triangles follow: 80 bytes of anything, their number, 50 bytes each.
bool hasSizeOfBinaryStl(std::span<const char> bytes);

/// "OBJ", "STL", "PLY", "OFF", "glTF".
const char* nameOf(MeshKind kind);

/// "a mesh (OBJ)", "a sphere-tree (.stree)", "a picture (PNG)", "a table (CSV)", "JSON", "empty"; "" for what is not
/// known.
std::string describedContent(std::string_view bytes);

}  // namespace spheretree::formats
