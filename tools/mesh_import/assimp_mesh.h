// SPDX-License-Identifier: GPL-3.0-or-later
// Reads meshes in further formats (3DS, 3MF, DAE, FBX and more) with Assimp.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>

#include "spheretree/formats/mesh_file.h"

namespace spheretree::mesh_import {

/// All triangles of the scene, with node transforms applied, in mm; each node with a mesh becomes a part with its name.
/// Only `bytes` is read, even if the file refers to other files. Skins and animations are ignored: meshes are as
/// stored.
/// `path`: its extension selects the format, and messages use it as the name of the file. `unit_mm`: one unit of the
/// file; empty: the unit in the file (FBX, DAE), otherwise 1 mm.
/// Assimp may crash on a malicious file: call this in a process of its own.
/// @throws formats::FormatError for a file that Assimp refuses or that has no triangle.
formats::MeshFile readByAssimp(std::span<const std::byte> bytes, const std::filesystem::path& path, std::optional<double> unit_mm);

}  // namespace spheretree::mesh_import
