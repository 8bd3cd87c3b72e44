// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes of other formats (3DS, 3MF, DAE, FBX and more) by Assimp.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>

#include "spheretree/formats/mesh_file.h"

namespace spheretree::mesh_import {

/// All triangles of the scene, where its nodes place them, in mm; each node with a mesh is a part of its name. Nothing
/// but `bytes` is read, whatever the file names. Skins and animations are ignored: meshes stand as they are stored.
/// `path`: whose ending tells the format, and which stands for the file in messages. `unit_mm`: one unit of the file;
/// nothing: what the file says (FBX, DAE), else 1 mm.
/// Assimp may crash on a file that was made to crash it: call this in a process that has nothing to lose.
/// @throws formats::FormatError for a file that Assimp refuses or that has no triangle.
formats::MeshFile readByAssimp(std::span<const std::byte> bytes, const std::filesystem::path& path, std::optional<double> unit_mm);

}  // namespace spheretree::mesh_import
