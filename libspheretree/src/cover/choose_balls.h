// SPDX-License-Identifier: GPL-3.0-or-later
// The discrete part of our own builder: for at most N balls, the smallest stand-off h such that balls of radius d(c) +
// h cover samples of the surface, where d is the distance to the mesh. This is the additively weighted k-centre
// problem. The next part, cover_search.h, moves the centres. Steps and papers: docs/algorithms/cover/choose_balls.md
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

struct ChoiceSettings {
  std::size_t spheres = 512;  // N, >= 1
  int refits = 3;             // passes that assign samples to balls and refit the balls; >= 0
  std::uint64_t seed = 1;
};

/// Chooses N balls and refits them to their samples. `samples`: points on `mesh`; `pool`: inscribed balls (radius
/// d(c)), the candidates. Deterministic for any number of threads.
/// @throws std::invalid_argument for no samples or no candidates.
ChosenBalls chooseBalls(const TriangleMesh& mesh, const DistanceField& field, std::span<const SurfaceSample> samples,
                        std::span<const Ball> pool, const ChoiceSettings& settings, Progress& progress);

/// An estimate of the stand-off of a greedy cover by `spheres` balls of the pool [mm], from a subset of samples and
/// candidates.
double roughStandOff(const DistanceField& field, std::span<const SurfaceSample> samples, std::span<const Ball> pool, std::size_t spheres,
                     const Progress& progress);

}  // namespace spheretree::builder
