// SPDX-License-Identifier: GPL-3.0-or-later
// Makes the boundary of a solid manifold where it touches itself: bodies that meet in one vertex or along one edge are
// moved apart inwards by a given distance, so that inside and outside are certain again.
// Units: mm. Deterministic.
#pragma once

#include "repair/repair_soup.h"

namespace spheretree::builder {

struct SeparatedFans {
  std::size_t copies = 0;      // vertices added
  double moved = 0;            // largest motion of a vertex [mm]
  std::vector<char> is_moved;  // for each triangle
};

/// Every vertex in which several fans of triangles meet gets a copy for each fan. The copies move inwards by `distance`
/// [mm], or by a hundredth of their shortest side if that is less. At an edge of four triangles or more, triangles with
/// solid matter between them stay together, and the edge gets a vertex in its middle. The triangles must be wound
/// outward and have no open edges; otherwise some fans stay together. If two triangles have the same corners
/// (repair_soup.h: cancelOpposites), nothing is changed. A triangle is divided once for each of its sides on such an
/// edge, so that n triangles become at most 4 n: the halves have a vertex of their own, and the edge to it has two
/// triangles.
SeparatedFans separateFans(RepairSoup& soup, double distance);

}  // namespace spheretree::builder
