// SPDX-License-Identifier: GPL-3.0-or-later
// How near a cut comes to a layer.
// Units: mm. Deterministic.
#pragma once

#include <optional>
#include <span>

#include "cut/swept_burr.h"
#include "geometry/distance_field.h"

namespace spheretree::builder {

struct CutDistance {
  double low = 0;              // no point that the burr swept is nearer to the layer [mm]
  std::optional<double> high;  // some removed point is this near; empty if none was found in the object
};

/// The least distance of the swept space within `object` to the solid `layer`; 0 if it reaches into it. The two bounds
/// differ by at most 1e-4 mm unless the nearest swept points lie outside the object. Empty without a path.
/// Method: branch and bound on the steps, since a distance changes by no more than its point moves.
std::optional<CutDistance> distanceOfCut(const DistanceField& object, const DistanceField& layer, std::span<const BurrPath> paths);

}  // namespace spheretree::builder
