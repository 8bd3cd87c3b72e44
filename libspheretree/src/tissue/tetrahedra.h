// SPDX-License-Identifier: GPL-3.0-or-later
// A solid as tetrahedra, on which elasticity is computed. They come from a separate program (tools/tetrahedra), and are
// checked here.
// Units: mm, frame of the mesh.
#pragma once

#include <cstdint>
#include <vector>

#include "spheretree/core/tissue.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

using Tetrahedra = TetrahedronList;  // all of positive volume after solidOf()

/// Volume of a tetrahedron [mm^3]; negative if it is inverted.
double volumeOf(const Tetrahedra& solid, std::size_t tetrahedron);

/// Total volume [mm^3].
double volumeOf(const Tetrahedra& solid);

/// Checks `found` against the closed `surface` that it has to fill, and normalises it: tetrahedra are oriented to
/// positive volume; tetrahedra in cavities, flat ones along the surface, and unused nodes are removed; nodes keep their
/// order.
/// @throws BuildError if an index is out of range, a number is not finite, an inner tetrahedron is flat, a face has
/// more than two tetrahedra, or the relative difference of the volume to that of the surface exceeds 1e-6.
Tetrahedra solidOf(const Tetrahedra& found, const TriangleMesh& surface);

/// The faces that belong to one tetrahedron only, wound outward; the vertices are all nodes. `owner`, if given,
/// receives the tetrahedron of each face.
TriangleMesh boundaryOf(const Tetrahedra& solid, std::vector<std::uint32_t>* owner = nullptr);

}  // namespace spheretree::builder
