// SPDX-License-Identifier: Apache-2.0
// A sphere-tree to look at: binary glTF 2.0 with a node for each sphere and one for the skin.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "spheretree/core/sphere_tree.h"

namespace spheretree::formats {

/// The spheres of each level set, in one colour a level: under the nodes level_0, level_1, ... a node sphere_N for each
/// node N of the tree, moved and scaled to its sphere. All of a level share one icosphere. Spheres above hide those
/// below, so each level is a scene of its own, and the scene that a viewer shows first is that of the leaves.
/// With `level` there is that level only. In metres, as glTF demands, in the frame of the mesh. `kind`: which spheres
/// of the inner nodes are shown. About 150 bytes a sphere and 30 kB a level. A tree with a skin also has a node skin
/// beside the leaves: its patches, 16 triangles each, with the normals that are felt; at most 20 MB.
std::vector<std::byte> encodeGlb(const SphereTree& tree, SphereKind kind, std::optional<int> level = {});

}  // namespace spheretree::formats
