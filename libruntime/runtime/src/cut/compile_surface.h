// SPDX-License-Identifier: Apache-2.0
// The surface of a layer that a burr cuts, in the memory layout of a skin.
#pragma once

#include "scene/compiled_skin.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::runtime {

/// The flat triangles of a mesh, with a search tree; `origin`: that of the mesh's frame minus the centre of the object.
/// At most kMaxSearchItems triangles. Cost: O(n log^2 n), 10 ms for 10,000 triangles.
CompiledSkin compileSurface(const TriangleMesh& mesh, const Eigen::Vector3d& origin);

}  // namespace spheretree::runtime
