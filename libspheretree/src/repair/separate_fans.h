// SPDX-License-Identifier: GPL-3.0-or-later
// Makes the boundary of a solid manifold where it touches itself: bodies that meet in one vertex or along one edge are
// drawn apart inwards by a given distance, so that inside and outside are certain again.
// Units: mm. Deterministic.
#pragma once

#include "repair/repair_soup.h"

namespace spheretree::builder {

struct SeparatedFans {
  std::size_t copies = 0;      // vertices added
  double moved = 0;            // most that a vertex moved [mm]
  std::vector<char> is_moved;  // for each triangle
};

/// Every vertex in which several fans of triangles meet gets a copy for each; the copies move inwards by `distance`
/// [mm], or a hundredth of their shortest side if that is less. At an edge of four triangles or more, those go together
/// that have solid matter between them, and the edge gets a vertex in its middle. The triangles must be wound outward,
/// have no open edges, and no two the same corners (repair_soup.h: cancelOpposites); else some stay together.
SeparatedFans separateFans(RepairSoup& soup, double distance);

}  // namespace spheretree::builder
