// SPDX-License-Identifier: GPL-3.0-or-later
#include "cover/build_cover.h"

#include <algorithm>
#include <functional>
#include <numeric>

#include "cover/optimise_cover.h"
#include "geometry/surface_samples.h"
#include "medial/shrinking_balls.h"
#include "medial/voronoi_balls.h"
#include "tree/hierarchy.h"

namespace spheretree::builder {

namespace {

struct Effort {
  std::size_t samples_a_sphere, least_samples;
  std::size_t candidates_a_sphere;  // for the choice that the squeeze starts from; more of them are hardly of use to it
  std::size_t medial_samples;       // points of the Delaunay triangulation, at least three a sphere
  std::size_t touching_samples;     // of them, those that get a shrinking ball
  std::uint64_t swap_work;
  int gap_rounds;
  double search_moves;  // a sphere
  std::uint64_t search_work;
  double search_step;
  int search_failures;
  double gap_tolerance;
};

Effort effortOf(Quality quality) {
  switch (quality) {
    case Quality::Quick:
      return {.samples_a_sphere = 12,
              .least_samples = 300,
              .candidates_a_sphere = 6,
              .medial_samples = 1500,
              .touching_samples = 300,
              .swap_work = 300'000,
              .gap_rounds = 1,
              .search_moves = 0.4,
              .search_work = 8'000'000,
              .search_step = 0.06,
              .search_failures = 4,
              .gap_tolerance = 0.03};
    case Quality::Standard:
      return {.samples_a_sphere = 24,
              .least_samples = 1000,
              .candidates_a_sphere = 20,
              .medial_samples = 6000,
              .touching_samples = 1500,
              .swap_work = 10'000'000,
              .gap_rounds = 3,
              .search_moves = 0.6,
              .search_work = 60'000'000,
              .search_step = 0.04,
              .search_failures = 5,
              .gap_tolerance = 0.02};
    case Quality::Best:
      return {.samples_a_sphere = 24,
              .least_samples = 1000,
              .candidates_a_sphere = 20,
              .medial_samples = 6000,
              .touching_samples = 1500,
              .swap_work = 10'000'000,
              .gap_rounds = 10,
              .search_moves = 2,
              .search_work = 400'000'000,
              .search_step = 0.03,
              .search_failures = 12,
              .gap_tolerance = 0.01};
  }
  return {};
}

template <class T>
std::vector<T> thinned(const std::vector<T>& all, std::size_t wanted) {
  if (all.size() <= wanted) return all;
  std::vector<T> few;
  few.reserve(wanted);
  for (std::size_t i = 0; i < wanted; ++i) few.push_back(all[i * all.size() / wanted]);
  return few;
}

// Voronoi vertices and shrinking balls of one sampling of the surface, fine enough for `spheres`.
// Balls for tissue lie between the surface and a sheet near the medial axis, where no Voronoi vertex is.
std::vector<Ball> medialPool(const TriangleMesh& mesh, const DistanceField& field, std::size_t spheres, const Effort& effort,
                             const BuildSettings& settings, Progress& progress) {
  SampleSettings sampling;
  sampling.count = std::max(effort.medial_samples, 3 * spheres);
  sampling.seed = settings.seed;
  const std::vector<SurfaceSample> samples = sampleSurface(mesh, sampling);
  if (settings.soft_share > 0) return shrinkingBalls(samples, field);
  std::vector<Eigen::Vector3d> points;
  for (const SurfaceSample& s : samples) points.push_back(s.point);
  progress.check();
  std::vector<Ball> pool = voronoiBalls(points, field);
  progress.check();
  // In a solid thinner than the spacing of the samples Voronoi vertices fail: they lie outside.
  const bool thin = pool.size() < samples.size() / 2;
  const std::vector<Ball> touching = shrinkingBalls(thinned(samples, thin ? samples.size() : effort.touching_samples), field);
  pool.insert(pool.end(), touching.begin(), touching.end());
  return pool;
}

/// The levels above `leaves`, each by `cover` with as many balls as it may have; `full`: leaves of a full tree.
LevelBalls levelsAbove(Cover leaves, std::size_t full, const BuildSettings& settings, const std::function<Cover(std::size_t)>& cover,
                       Progress& progress) {
  // With a tolerance, no more spheres above than the leaves need as parents.
  std::vector<std::size_t> counts(static_cast<std::size_t>(settings.levels), 1);
  for (std::size_t level = 1; level < counts.size(); ++level)
    counts[level] = std::min(counts[level - 1] * static_cast<std::size_t>(settings.branching), leaves.balls.size());
  if (leaves.balls.size() < full && (settings.tolerance_mm > 0 || settings.most_leaves > 0))
    counts = levelCounts(leaves.balls.size(), settings.branching);
  std::vector<Cover> covers(counts.size());
  covers.back() = std::move(leaves);
  const std::size_t total = std::accumulate(counts.begin(), counts.end(), std::size_t{0});
  std::size_t done = 0;
  for (std::size_t level = counts.size() - 1; level-- > 0;) {
    done += counts[level + 1];
    progress.advance(static_cast<double>(done) / static_cast<double>(total));  // the time goes by the spheres
    covers[level] = cover(std::min(counts[level], covers[level + 1].balls.size()));
  }
  LevelBalls levels;
  for (std::size_t level = 0; level < covers.size(); ++level) {
    // Of a round object eight balls may reach out no farther than 64 that are each searched for less.
    if (level > 0 && covers[level].stand_off > covers[level - 1].stand_off) covers[level] = covers[level - 1];
    levels.balls.push_back(covers[level].balls);
  }
  return levels;
}

}  // namespace

LevelBalls buildCover(const TriangleMesh& mesh, const DistanceField& field, const BuildSettings& settings, Progress& progress) {
  const Effort effort = effortOf(settings.quality);
  std::size_t full = 1;
  for (int level = 1; level < settings.levels; ++level) full *= static_cast<std::size_t>(settings.branching);
  const std::size_t budget = settings.most_leaves > 0 ? std::min(full, static_cast<std::size_t>(settings.most_leaves)) : full;

  // With a tolerance, one level after the other: a tree deeper than it needs would cost eight times as much to find
  // out.
  std::size_t low = 0, high = settings.tolerance_mm > 0 ? std::min(budget, static_cast<std::size_t>(settings.branching)) : budget;
  std::size_t fitted = 0;  // number of spheres that the pool and the effort are made for
  std::vector<Ball> pool;
  const auto fitPool = [&] {
    progress.stage("medial axis");
    fitted = high;
    pool = medialPool(mesh, field, fitted, effort, settings, progress);
    if (pool.empty()) throw BuildError("no ball fits inside the mesh: it is too thin for double precision, or inside out");
    progress.stage("cover");
  };

  const auto cover = [&](std::size_t spheres) {
    CoverSettings cover_settings;
    cover_settings.spheres = spheres;
    cover_settings.swap_work = effort.swap_work / fitted * std::max(spheres, fitted / 10 + 1);
    cover_settings.gap_rounds = effort.gap_rounds;
    cover_settings.lowering.moves = 10 + static_cast<int>(effort.search_moves * static_cast<double>(spheres));
    cover_settings.lowering.step = effort.search_step;
    cover_settings.lowering.work = effort.search_work;
    cover_settings.lowering.failures = effort.search_failures;
    cover_settings.lowering.gap_tolerance = effort.gap_tolerance;
    cover_settings.lowering.closes = true;
    cover_settings.seed = settings.seed + spheres;
    SampleSettings sampling;
    sampling.count = std::max(effort.least_samples, effort.samples_a_sphere * spheres);
    sampling.seed = settings.seed + 1;
    // Memory grows with the candidates; in very deep trees eight a sphere do.
    const std::size_t candidates =
        std::max<std::size_t>(400, std::min(effort.candidates_a_sphere * spheres, std::max<std::size_t>(200'000, 8 * spheres)));
    return optimiseCover(mesh, field, sampleSurface(mesh, sampling), thinned(pool, candidates), cover_settings, progress);
  };

  fitPool();
  Cover leaves = cover(high);
  while (leaves.stand_off > settings.tolerance_mm && high < budget) {  // low is too few, high suffices or is all there is
    low = high;
    high = std::min(budget, high * static_cast<std::size_t>(settings.branching));
    fitPool();
    leaves = cover(high);
  }
  if (settings.tolerance_mm > 0 && leaves.stand_off < settings.tolerance_mm) {
    // The stand-off falls about as 1/n: start there, then close in on the fewest.
    for (int step = 0; step < 12 && high - low > std::max<std::size_t>(1, high / 100); ++step) {
      const double guess = static_cast<double>(high) * leaves.stand_off / settings.tolerance_mm;
      std::size_t middle = low + (high - low) / 2;
      if (step % 2 == 0) middle = std::clamp<std::size_t>(static_cast<std::size_t>(guess), low + 1, high - 1);
      Cover fewer = cover(middle);
      if (fewer.stand_off <= settings.tolerance_mm) {
        high = middle;
        leaves = std::move(fewer);
      } else {
        low = middle;
      }
    }
  }
  return levelsAbove(std::move(leaves), full, settings, cover, progress);
}

}  // namespace spheretree::builder
