// SPDX-License-Identifier: GPL-3.0-or-later
// The whole search for a cover of a given number of balls, as in the builder `cover`.
#pragma once

#include "cover/cover_search.h"
#include "cover/farthest_points.h"
#include "geometry/surface_samples.h"

namespace spheretree::test {

inline builder::Cover foundCover(const TriangleMesh& mesh, std::span<const builder::SurfaceSample> samples, std::size_t spheres,
                                 const builder::SearchSettings& settings, builder::Progress& progress) {
  const builder::DistanceField field(mesh);
  builder::SearchStart start{.count = spheres};
  for (const builder::SurfaceSample& s : samples) start.samples.push_back(s.point);
  start.balls = builder::farthestPointBalls(field, start.samples, spheres);
  builder::CoverSearch search(mesh, field, std::move(start), settings, progress);
  search.lower(0, progress);
  return search.cover();
}

}  // namespace spheretree::test
