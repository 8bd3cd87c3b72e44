// SPDX-License-Identifier: GPL-3.0-or-later
// A solid within a cube, between two convex sets.
// Units: mm.
#pragma once

#include <Eigen/Core>
#include <array>

#include "cut/convex_cell.h"
#include "geometry/distance_field.h"

namespace spheretree::builder {

/// A part of a cube: empty, or the cube in up to two half-spaces.
struct CellPart {
  bool is_empty = false;
  int count = 0;  // half-spaces
  std::array<HalfSpace, 2> half_spaces{};
  bool isWhole() const { return !is_empty && count == 0; }
};

/// Within the cube, `inner` is certainly within the set, and the set is certainly within `outer`.
struct CellBounds {
  CellPart inner, outer;
};

struct SolidInCell {
  CellBounds inside, outside;  // of the solid; of its complement
  bool isInside() const { return inside.inner.isWhole(); }
  bool isOutside() const { return outside.inner.isWhole(); }
};

/// Of a cube that is wholly inside or outside of the solid, as is each part of it.
SolidInCell wholeCell(bool is_inside);

/// All triangles that meet the cube lie in a slab perpendicular to their mean normal. On each side of the slab all
/// points are inside, or all outside; one point tells. The slab is thin where the surface is flat or has gentle edges:
/// the volume between the bounds shrinks with the fourth power of the cube's size.
SolidInCell boundSolid(const DistanceField& solid, const Eigen::Vector3d& centre, double half);

}  // namespace spheretree::builder
