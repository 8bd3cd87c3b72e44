// SPDX-License-Identifier: GPL-3.0-or-later
// How much a burr has removed of each layer, as intervals that contain the true volume.
//
// An octree whose cells are certainly inside, certainly outside or undecided. In an undecided cell, the swept space and
// the layers lie between convex sets, whose volumes are exact: docs/algorithms/cut/cut_volumes.md
// Units: mm. Deterministic for any number of threads.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "cut/swept_burr.h"
#include "geometry/distance_field.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

struct VolumeBounds {
  double low = 0, high = 0;  // [mm^3]
  double width() const { return high - low; }
};

/// A layer is what is inside its mesh and the first mesh, and outside of the meshes after it.
using LayerFields = std::span<const DistanceField>;

struct CutVolumes {
  std::vector<VolumeBounds> layers;  // removed of each
  VolumeBounds total;                // removed of the object
  bool is_met = true;                // the tolerance; false if `max_cells` were not enough
  std::size_t cells = 0;             // examined
};

struct CutVolumeSettings {
  double tolerance = 0;  // of the sum of the widths of all layers [mm^3]; 0: 0.5 % of the removed volume, at least 1e-4 mm^3
  std::size_t max_cells = 2'000'000;
};

/// @throws Cancelled
CutVolumes removedVolumes(LayerFields layers, std::span<const BurrPath> paths, const CutVolumeSettings& settings, Progress& progress);

}  // namespace spheretree::builder
