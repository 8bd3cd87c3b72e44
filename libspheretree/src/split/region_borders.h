// SPDX-License-Identifier: GPL-3.0-or-later
// The borders of the regions of a cut scan: their edges, the loops that these form, and where several borders meet.
#pragma once

#include <cstdint>
#include <vector>

#include "split/scan_surface.h"

namespace spheretree::builder {

/// A border edge of a region, in the direction of its triangles, and the region on the other side.
struct BorderEdge {
  std::uint32_t from, to;
  std::int32_t other;
};

class RegionBorders {
 public:
  /// `surface` must outlive this object and keep its triangles and their regions; vertices may be appended.
  explicit RegionBorders(const ScanSurface& surface);

  std::int32_t regionCount() const { return static_cast<std::int32_t>(edges_of_.size()); }
  /// In the order of the triangles. Beyond an open edge of the surface is the gum.
  const std::vector<BorderEdge>& edgesOf(std::int32_t region) const { return edges_of_[static_cast<std::size_t>(region)]; }
  /// The closed loops of these edges. At a vertex that several loops share, each one turns through the triangles of the
  /// region.
  std::vector<std::vector<BorderEdge>> loopsOf(std::int32_t region) const;
  /// Whether an arc ends between two consecutive edges of a loop: the neighbour changes, or more than two borders meet.
  bool isNode(const BorderEdge& before, const BorderEdge& after) const {
    return before.other != after.other || borders_at_[after.from] != 2;
  }

 private:
  BorderEdge next(std::int32_t region, const BorderEdge& edge) const;

  const ScanSurface& surface_;
  EdgeFaces faces_;
  std::vector<std::vector<BorderEdge>> edges_of_;
  std::vector<std::uint32_t> borders_at_;  // of each vertex: number of border edges that begin there
};

}  // namespace spheretree::builder
