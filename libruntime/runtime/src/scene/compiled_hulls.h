// SPDX-License-Identifier: Apache-2.0
// The hulls of a tool (core/hulls.h) in the memory layout of the search and of the rows: a search tree over their
// items, and for each slot the balls of the part.
// Units: mm; frame: axes of the tool, origin at its reference point.
#pragma once

#include <cstdint>
#include <vector>

#include "scene/compiled_tree.h"
#include "spheretree/core/hulls.h"

namespace spheretree::runtime {

struct CompiledHulls {
  CompiledTree tree;
  std::vector<Sphere> ball;          // (slot) ball 0 of the part; of an inner node: its bounding sphere
  std::vector<Sphere> span1, span2;  // (slot) balls 1 and 2 minus ball 0; 0 if there are none
  std::vector<std::uint32_t> way;    // (slot) which of the part's items it is
  std::vector<std::uint32_t> part;   // (item)
  float smallest_radius = 0;         // of the balls [mm]

  bool empty() const { return ball.empty(); }
};

/// `origin`: origin of the hulls' frame minus the reference point of the tool.
CompiledHulls compileHulls(const Hulls& hulls, const Eigen::Vector3d& origin);

}  // namespace spheretree::runtime
