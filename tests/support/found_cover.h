// SPDX-License-Identifier: GPL-3.0-or-later
// The whole search for a cover of a given number of balls, as in the builder `cover`.
#pragma once

#include "cover/choose_balls.h"
#include "cover/cover_search.h"

namespace spheretree::test {

inline builder::Cover foundCover(const TriangleMesh& mesh, std::span<const builder::SurfaceSample> samples,
                                 std::span<const builder::Ball> pool, std::size_t spheres, const builder::SearchSettings& settings,
                                 builder::Progress& progress) {
  const builder::DistanceField field(mesh);
  builder::CoverSearch search(mesh, field, builder::chooseBalls(mesh, field, samples, pool, spheres, 1, progress), settings, progress);
  search.lower(0, progress);
  return search.cover();
}

}  // namespace spheretree::test
