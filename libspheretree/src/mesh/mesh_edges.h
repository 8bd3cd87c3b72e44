// SPDX-License-Identifier: GPL-3.0-or-later
// The edges of a mesh with the triangles at each edge, as the checks use them.
#pragma once

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <tuple>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

class Groups {  // union-find; the root of a group is its lowest member
 public:
  explicit Groups(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0u); }
  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = root(a), b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

struct Side {          // one triangle at one edge
  std::uint64_t edge;  // lower vertex << 32 | higher vertex
  std::uint32_t triangle;
  std::uint8_t corner;  // the edge runs from this corner to the next
  bool forward;         // from the lower to the higher vertex

  std::uint32_t low() const { return static_cast<std::uint32_t>(edge >> 32); }
  std::uint32_t high() const { return static_cast<std::uint32_t>(edge); }
};

/// Three sides for each triangle of three different corners, sorted by edge, then by triangle.
inline std::vector<Side> sortedSides(const TriangleMesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(mesh.triangles.size() * 3);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& corners = mesh.triangles[t];
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
    for (std::uint8_t k = 0; k < 3; ++k) {
      const std::uint32_t a = corners[k], b = corners[(k + 1) % 3];
      sides.push_back({std::uint64_t{std::min(a, b)} << 32 | std::max(a, b), t, k, a < b});
    }
  }
  tbb::parallel_sort(sides.begin(), sides.end(),
                     [](const Side& a, const Side& b) { return std::tie(a.edge, a.triangle) < std::tie(b.edge, b.triangle); });
  return sides;
}

/// Calls `visit(first, last)` with the range of sides of each edge.
template <class Visit>
void forEachEdge(const std::vector<Side>& sides, Visit&& visit) {
  for (std::size_t first = 0, last = 0; first < sides.size(); first = last) {
    last = first + 1;
    while (last < sides.size() && sides[last].edge == sides[first].edge) ++last;
    visit(first, last);
  }
}

}  // namespace spheretree::builder
