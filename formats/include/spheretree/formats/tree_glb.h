// SPDX-License-Identifier: Apache-2.0
// A sphere-tree for viewing: binary glTF 2.0 with a node for each sphere and one for the skin.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "spheretree/core/sphere_tree.h"

namespace spheretree::formats {

/// The spheres of each level set, with one colour for each level. Below the nodes level_0, level_1, ... there is a node
/// sphere_N for each node N of the tree, with the translation and scale of its sphere. All spheres of a level share one
/// icosphere. Since spheres of upper levels hide those below, each level is a scene of its own, and the default scene
/// shows the leaves.
/// With `level`, only that level is written. In metres, as glTF requires, in the frame of the mesh. `kind`: which
/// spheres of the inner nodes are shown. About 150 bytes a sphere and 30 kB a level. A tree with a skin also has a node
/// `skin` beside the leaves: its patches, 16 triangles each, with their smooth normals; at most 20 MB. Hulls have
/// a scene of their own, `scene_of_hulls`, with their parts.
std::vector<std::byte> encodeGlb(const SphereTree& tree, SphereKind kind, std::optional<int> level = {});

}  // namespace spheretree::formats
