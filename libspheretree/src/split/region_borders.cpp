// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/region_borders.h"

#include <algorithm>
#include <map>
#include <utility>

namespace spheretree::builder {

RegionBorders::RegionBorders(const ScanSurface& surface)
    : surface_(surface), faces_(surface.mesh), edges_of_(surface.region_label.size()), borders_at_(surface.mesh.positions.size(), 0) {
  const std::vector<Triangle>& triangles = surface.mesh.triangles;
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3], other = faces_.face(b, a);
      const std::int32_t beyond = other == kNone ? kGumRegion : surface.region[other];
      if (beyond == surface.region[t]) continue;
      edges_of_[static_cast<std::size_t>(surface.region[t])].push_back({a, b, beyond});
      ++borders_at_[a];
    }
}

/// The next border edge of the region, going around the end of `edge` through its triangles.
BorderEdge RegionBorders::next(std::int32_t region, const BorderEdge& edge) const {
  std::uint32_t face = faces_.face(edge.from, edge.to);
  for (;;) {
    const Triangle& t = surface_.mesh.triangles[face];
    const std::size_t k = static_cast<std::size_t>(std::find(t.begin(), t.end(), edge.to) - t.begin());
    const std::uint32_t to = t[(k + 1) % 3], beyond = faces_.face(to, edge.to);
    if (beyond == kNone) return {edge.to, to, kGumRegion};
    if (surface_.region[beyond] != region) return {edge.to, to, surface_.region[beyond]};
    face = beyond;
  }
}

std::vector<std::vector<BorderEdge>> RegionBorders::loopsOf(std::int32_t region) const {
  const std::vector<BorderEdge>& edges = edgesOf(region);
  std::map<std::pair<std::uint32_t, std::uint32_t>, char> is_used;
  for (const BorderEdge& e : edges) is_used[{e.from, e.to}] = 0;
  std::vector<std::vector<BorderEdge>> loops;
  for (const BorderEdge& start : edges) {
    if (is_used[{start.from, start.to}]) continue;
    std::vector<BorderEdge> loop;
    for (BorderEdge at = start; !is_used[{at.from, at.to}]; at = next(region, at)) {
      is_used[{at.from, at.to}] = 1;
      loop.push_back(at);
    }
    loops.push_back(std::move(loop));
  }
  return loops;
}

}  // namespace spheretree::builder
