// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes and trees as a page's 3D view takes them: quantised to 16 bits, which is 1/65535 of their size and no figure
// is read from.
#pragma once

#include "mesh/surface_with_sheets.h"
#include "page/page.h"
#include "spheretree/core/sphere_tree.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::tool {

/// The mesh with at most about `triangles` triangles (holes and handles stay, and may need more), its vertices on the
/// surface, and the sheets of its `surface`.
Json packMesh(PageData& data, const TriangleMesh& mesh, const builder::SurfaceWithSheets& surface, std::size_t triangles);

/// Cover spheres of all nodes, and which level sets each belongs to. With a `field`, how far each sphere reaches out of
/// the object at most: its radius plus the signed distance of its centre, as the builder's certificate has it.
Json packTree(PageData& data, const SphereTree& tree, const builder::DistanceField* field);

}  // namespace spheretree::tool
