// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes and trees for the 3D view of a page: quantised to 16 bits, that is to 1/65535 of their size. No figure is
// computed from them.
#pragma once

#include "mesh/surface_with_sheets.h"
#include "page/page.h"
#include "spheretree/core/sphere_tree.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::tool {

/// The mesh reduced to about `triangles` triangles (it may have more, since holes and handles are kept), with vertices
/// on the surface, and the sheets of its `surface`.
Json packMesh(PageData& data, const TriangleMesh& mesh, const builder::SurfaceWithSheets& surface, std::size_t triangles);

/// Cover spheres of all nodes, and the level sets of each. With a `field`, also an upper bound of the overhang of each
/// sphere: its radius plus the signed distance of its centre, as in the builder's certificate.
Json packTree(PageData& data, const SphereTree& tree, const builder::DistanceField* field);

}  // namespace spheretree::tool
