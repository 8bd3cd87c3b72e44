// SPDX-License-Identifier: GPL-3.0-or-later
// How far a union of balls reaches out of the solid: the distance to the mesh over the part of the union's boundary
// that lies outside it. The distance is sampled, and its maximum gets a proven upper bound. Definitions:
// docs/measures.md
// Units: mm. Deterministic: same arguments, same result, for any number of threads.
#pragma once

#include <cstdint>

#include "geometry/distance_field.h"
#include "geometry/sphere_union.h"
#include "spheretree/builder/evaluation.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

struct OverhangSettings {
  std::size_t samples = 400000;  // distributed over the balls by area
  std::size_t min_per_ball = 400;
  std::size_t max_per_ball = 40000;
  double relative_gap = 1e-4;           // the proof ends once bound <= max (1 + relative_gap) ...
  double absolute_gap = 1e-6;           // ... or bound <= max + absolute_gap of the mesh's diagonal; > 0
  std::size_t max_patches = 8'000'000;  // then the proof ends with its current bound, which is still proven
};

/// The sign of the distance is DistanceField's: the mesh must be closed, oriented and free of self-intersections.
/// Cost: about one distance query for each sample on the boundary, and a few thousand to a million for the proof.
/// @throws Cancelled, std::invalid_argument for settings out of range.
Overhang measureOverhang(const DistanceField& field, const SphereUnion& balls, const OverhangSettings& settings, Progress& progress);

}  // namespace spheretree::builder
