// SPDX-License-Identifier: GPL-3.0-or-later
// Lowers the stand-off of a cover by moving its balls: local search in continuous space, one uncovered point at a time.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/ball.h"
#include "geometry/distance_field.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

struct StandOffSettings {
  double start = 1.1;                // the first goal, times the stand-off on the samples: what they miss is covered there first; >= 1
  double step = 0.02;                // each goal is this share below the last, at first; range (0, 0.5)
  int moves = 1000;                  // balls moved before a goal is given up, counted anew whenever all samples are covered; >= 0
  std::uint64_t work = 100'000'000;  // triangles and points looked at before the search ends: bounds its time on any mesh
  int failures = 4;                  // goals given up, each halves the step, before the search ends; >= 0
  double enough = 0;                 // the search ends once the stand-off is no more [mm]; >= 0
  double gap_spacing = 0.03;         // new samples are this far apart, as a share of the width of a patch; > 0
  double gap_tolerance = 0.02;       // holes shallower than this share of the stand-off may be left to the certificate; > 0
  bool closes = false;  // in the end, more of the holes within the tolerance are closed by moves: takes up to a quarter of `work`
  std::uint64_t seed = 1;
};

/// `inscribed`: balls of radius d(c), the centres of the cover; moved in place. `points`: samples on the surface;
/// uncovered points of the mesh are appended as they are found, so that the result covers the mesh but for gaps too
/// small to sample. Returns the stand-off [mm]. Sequential; deterministic.
///
/// A goal below the present stand-off leaves some samples uncovered. Each in turn is given to a ball near it: the ball
/// is refitted to the samples that it alone covers and to the new one. If no ball can take it, the one that has to give
/// up least does, and what it gave up is open in its place. Samples that are open often weigh more, as in the swap
/// search.
double lowerStandOff(const TriangleMesh& mesh, const DistanceField& field, std::vector<Eigen::Vector3d>& points,
                     std::vector<Ball>& inscribed, const StandOffSettings& settings, Progress& progress);

}  // namespace spheretree::builder
