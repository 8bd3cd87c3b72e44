// SPDX-License-Identifier: Apache-2.0
// glTF 2.0 and GLB: the triangles of the default scene, with node transforms applied, converted from metres to
// millimetres. If there is no default scene, the first scene is used; if there is no scene, all root nodes. A mirroring
// transform reverses the winding. Parts are named after nodes, or after meshes if the node has no name; instances
// (EXT_mesh_gpu_instancing) have their number appended. Skins are in their rest pose, and morph
// targets have the weights of the file. Hidden nodes (KHR_node_visibility) are left out. EXT_meshopt_compression and
// KHR_draco_mesh_compression are decoded. Of materials only
// the base colour is read. Points, lines and animations are ignored.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "spheretree/formats/mesh_content.h"

namespace spheretree::formats {

/// `name` is the name of the file in messages. `unit_mm`: one unit of the file; glTF prescribes metres, but some
/// programs write other units. External buffers are searched in `folder`, never outside it; with an empty `folder` they
/// are refused. Cost: O(size of the file and its buffers, and of the triangles of all nodes; their number is limited to
/// 4 million or to the number of bytes in the file, whichever is larger).
/// @throws FileError if a buffer cannot be read; FormatError for all other errors.
MeshFile readGltf(std::span<const char> bytes, const std::string& name, const std::filesystem::path& folder = {}, double unit_mm = 1000);

}  // namespace spheretree::formats
