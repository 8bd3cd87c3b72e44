// SPDX-License-Identifier: GPL-3.0-or-later
// Moves the inner vertices of a wall or a filling until it crosses nothing. Units: mm.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "split/crossing_search.h"

namespace spheretree::builder {

inline constexpr double kSheetDensity = 0.5;  // of a sheet that is moved, in triangles along the edges of its border

/// New triangles, which connect vertices that stay and vertices that may move.
struct MovableSheet {
  std::vector<Triangle> triangles = {};
  std::vector<std::uint32_t> group = {};  // of each triangle; both halves of a triangle keep it
  std::size_t first_new = 0;              // vertices from here on belong to the sheet alone, and may move
  double edge = 0;                        // mean edge of its border [mm]
};

/// Moves new vertices until the sheet crosses nothing: to the right side of what they cross; where the sheet crosses
/// itself, to the mean of their neighbours. If that does not help, halves the triangles there, which appends vertices.
/// `outOf(i)`: unit normal of triangle i of the search, pointing away from the side where the sheet may be. Returns the
/// number of pairs that still cross; the sheet is the one with the fewest. Cost: at most kMaxRounds rounds
/// without a reduction of the pairs, each a search for the crossings of the sheet.
std::size_t moveApart(std::vector<Eigen::Vector3d>& positions, MovableSheet& sheet, const CrossingSearch& search,
                      const std::function<Eigen::Vector3d(std::uint32_t)>& outOf);

/// Halves each triangle at an edge that `isBad` names by its ends, until there is no such edge; appends the middles.
void splitEdges(std::vector<Eigen::Vector3d>& positions, MovableSheet& sheet,
                const std::function<bool(std::uint32_t, std::uint32_t)>& isBad);

}  // namespace spheretree::builder
