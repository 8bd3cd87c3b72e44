// SPDX-License-Identifier: GPL-3.0-or-later
// How far a hull of balls reaches out of a solid, with a proof: branch and bound over the weights of its balls.
// docs/algorithms/hulls/hull_overhang.md
// Units: mm.
#pragma once

#include "geometry/distance_field.h"
#include "geometry/hull.h"

namespace spheretree::builder {

struct HullOverhangSettings {
  double relative = 1e-3;    // the search ends when the bound exceeds what is attained by at most this share of it,
  double absolute = 0;       // or by this length [mm]
  double accept = 0;         // or if the bound is at most this [mm];
  double limit = kInfinity;  // it also ends once more than this is attained [mm]
  // and after this number of pieces. Some dozens are usual; what is proven by then is a bound all the same.
  std::size_t max_pieces = 1'000'000;
};

struct HullOverhang {
  double attained;  // of some ball of the hull: its radius plus the signed distance of its centre [mm]
  double bound;     // proven: no ball of the hull has more [mm]
};

/// Deterministic. Cost: some dozens of distance queries for a cone that follows the surface.
HullOverhang hullOverhang(const DistanceField& field, const Hull& hull, HullOverhangSettings settings);

}  // namespace spheretree::builder
