// SPDX-License-Identifier: GPL-3.0-or-later
// A solid in tetrahedra: what elasticity is computed on. They come from a program of their own (tools/tetrahedra);
// nothing that it says is trusted.
// Units: mm, frame of the mesh.
#pragma once

#include <cstdint>
#include <vector>

#include "spheretree/core/tissue.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

using Tetrahedra = TetrahedronList;  // of positive volume once solidOf() made them

/// Of a tetrahedron [mm^3]; negative if it is inside out.
double volumeOf(const Tetrahedra& solid, std::size_t tetrahedron);

/// Sum over all [mm^3].
double volumeOf(const Tetrahedra& solid);

/// `found`, checked against the closed `surface` that it is to fill, and put in order: tetrahedra turned to positive
/// volume; those in cavities, flat ones along the surface and nodes of no tetrahedron left out; nodes in their order.
/// @throws BuildError if an index is out of range, a number is not finite, a tetrahedron inside is flat, a face has
/// more than two tetrahedra, or the volume differs from that of the surface by more than 1e-6 of it.
Tetrahedra solidOf(const Tetrahedra& found, const TriangleMesh& surface);

/// Faces of one tetrahedron only, wound outward; vertices are the nodes, all of them. `owner`, if given: the
/// tetrahedron of each face.
TriangleMesh boundaryOf(const Tetrahedra& solid, std::vector<std::uint32_t>* owner = nullptr);

}  // namespace spheretree::builder
