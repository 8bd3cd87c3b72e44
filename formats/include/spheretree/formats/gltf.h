// SPDX-License-Identifier: Apache-2.0
// glTF 2.0 and GLB: the triangles of the default scene, its node transforms applied, metres turned into millimetres.
// Without a scene all root nodes count; of several scenes without a default the first. A mirroring transform turns the
// winding round. Parts are named after nodes, else meshes; instances (EXT_mesh_gpu_instancing) have their number behind
// the name. Skins stand in their rest pose. Data compressed by EXT_meshopt_compression and KHR_draco_mesh_compression
// are unpacked. Points, lines, materials, animations and morph targets are ignored.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "spheretree/formats/mesh_file.h"

namespace spheretree::formats {

/// `name` stands for the file in messages. `unit_mm`: one unit of the file; glTF says metres, but some programs write
/// what they have. Buffers in other files are looked for in `folder`, never outside it; an empty `folder`
/// refuses them. Cost: O(size of the file and its buffers, and of the triangles of all nodes, which are limited to 4
/// million or to as many as the file has bytes, whichever is more).
/// @throws FileError if a buffer cannot be read; FormatError for the rest.
MeshFile readGltf(std::span<const char> bytes, const std::string& name, const std::filesystem::path& folder = {}, double unit_mm = 1000);

}  // namespace spheretree::formats
