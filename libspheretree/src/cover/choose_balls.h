// SPDX-License-Identifier: GPL-3.0-or-later
// The discrete part of our own builder: for at most N balls, the smallest stand-off h such that balls of radius d(c) +
// h cover samples of the surface, where d is the distance to the mesh. This is the additively weighted k-centre
// problem. The search proper, cover_search.h, starts from these balls and moves their centres. Steps and papers:
// docs/algorithms/cover/choose_balls.md
#pragma once

#include <span>

#include "base/ball.h"
#include "cover/cover_search.h"
#include "geometry/distance_field.h"
#include "geometry/surface_samples.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

inline constexpr std::size_t kRoughSamples = 10;      // samples for each sphere of the cover that estimates a stand-off
inline constexpr std::size_t kMinRoughSamples = 500;  // at least, for few spheres

/// Chooses at most `spheres` balls (>= 1). `samples`: points on `mesh`; `pool`: inscribed balls (radius d(c)), the
/// candidates. `seed`: of additional samples, and of the search that starts here. Deterministic for any number of
/// threads.
/// @throws std::invalid_argument for no samples or no candidates.
ChosenBalls chooseBalls(const TriangleMesh& mesh, const DistanceField& field, std::span<const SurfaceSample> samples,
                        std::span<const Ball> pool, std::size_t spheres, std::uint64_t seed, Progress& progress);

/// An estimate of the stand-off of a greedy cover by `spheres` balls of the pool [mm], from a subset of samples and
/// candidates.
double roughStandOff(const DistanceField& field, std::span<const SurfaceSample> samples, std::span<const Ball> pool, std::size_t spheres,
                     const Progress& progress);

}  // namespace spheretree::builder
