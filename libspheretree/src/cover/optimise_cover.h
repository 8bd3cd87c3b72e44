// SPDX-License-Identifier: GPL-3.0-or-later
// Our own builder's core: for at most N balls, the least stand-off h such that balls of radius d(c) + h cover the
// surface, d the distance to the mesh. This is the additively weighted k-centre problem. Steps and papers:
// docs/algorithms/cover/optimise_cover.md
#pragma once

#include <span>
#include <vector>

#include "base/ball.h"
#include "cover/lower_stand_off.h"
#include "geometry/distance_field.h"
#include "geometry/surface_samples.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

struct CoverSettings {
  std::size_t spheres = 512;              // N, >= 1
  std::uint64_t swap_work = 200'000'000;  // entries of the candidate table that the swaps may touch: their time, on any mesh
  int refits = 3;                         // passes of assigning samples to balls and refitting them; >= 0
  int gap_rounds = 3;  // of swaps with samples where the mesh was open, on objects that uniform samples do not suit; >= 0
  StandOffSettings lowering;
  std::uint64_t seed = 1;
};

struct Cover {
  std::vector<Ball> balls;  // radius = d(c) + stand_off
  double stand_off = 0;     // h [mm]
};

/// Covers `mesh`. `samples`: points on it; `pool`: inscribed balls (radius d(c)), the candidates of the discrete
/// search. Uncovered by at most lowering.gap_tolerance of the stand-off, here and there, which certifyCover closes.
/// Deterministic for any number of threads.
/// @throws std::invalid_argument for no samples or no candidates.
Cover optimiseCover(const TriangleMesh& mesh, const DistanceField& field, std::span<const SurfaceSample> samples,
                    std::span<const Ball> pool, const CoverSettings& settings, Progress& progress);

}  // namespace spheretree::builder
