// SPDX-License-Identifier: GPL-3.0-or-later
#include "cover/build_cover.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/thinned.h"
#include "geometry/surface_samples.h"
#include "medial/shrinking_balls.h"
#include "medial/voronoi_balls.h"
#include "tree/hierarchy.h"

namespace spheretree::builder {

namespace {

constexpr int kMaxGuesses = 4;  // guesses of the number of leaves for a tolerance; each has about half the error of the previous one
constexpr std::size_t kMedialSamplesASphere = 3;  // points of the Delaunay triangulation for each sphere, at least
constexpr std::size_t kFewInside = 2;             // pools with fewer Voronoi balls than one over this of the samples are of a thin solid
constexpr std::size_t kMinCandidates = 400, kManyCandidates = 200'000;
constexpr std::size_t kCandidatesIfMany = 8;  // for each sphere, if there are many; memory grows with them

struct Effort {
  std::size_t samples_a_sphere, min_samples;
  std::size_t candidates_a_sphere;  // of the first choice, from which the cover search starts; more of them hardly improve the result
  std::size_t medial_samples;       // points of the Delaunay triangulation, at least kMedialSamplesASphere for each sphere
  std::size_t touching_samples;     // how many of these points get a shrinking ball
  double search_moves;              // for each sphere
  std::uint64_t search_work;
  double search_step, last_step;
  double gap_tolerance;
  double removal_moves;  // for each sphere
  int removal_failures;
  std::size_t starts;  // searches for the fewest leaves, each from balls of its own
};

Effort effortOf(Quality quality) {
  switch (quality) {
    case Quality::Quick:
      return {.samples_a_sphere = 10,
              .min_samples = 300,
              .candidates_a_sphere = 6,
              .medial_samples = 1500,
              .touching_samples = 300,
              .search_moves = 0.36,
              .search_work = 10'000'000,
              .search_step = 0.08,
              .last_step = 0.012,
              .gap_tolerance = 0.03,
              .removal_moves = 8,
              .removal_failures = 5,
              .starts = 1};
    case Quality::Standard:
      return {.samples_a_sphere = 16,
              .min_samples = 1000,
              .candidates_a_sphere = 20,
              .medial_samples = 6000,
              .touching_samples = 1500,
              .search_moves = 0.7,
              .search_work = 40'000'000,
              .search_step = 0.06,
              .last_step = 0.007,
              .gap_tolerance = 0.02,
              .removal_moves = 25,
              .removal_failures = 6,
              .starts = 1};
    case Quality::Best:
      return {.samples_a_sphere = 16,
              .min_samples = 1000,
              .candidates_a_sphere = 20,
              .medial_samples = 6000,
              .touching_samples = 1500,
              .search_moves = 2.2,
              .search_work = 400'000'000,
              .search_step = 0.04,
              .last_step = 0.0008,
              .gap_tolerance = 0.01,
              .removal_moves = 150,
              .removal_failures = 13,
              .starts = 5};
  }
  return {};
}

// Voronoi vertices and shrinking balls of one sampling of the surface, with `count` points.
std::vector<Ball> medialPool(const TriangleMesh& mesh, const DistanceField& field, std::size_t count, const Effort& effort,
                             std::uint64_t seed, bool is_soft, Progress& progress) {
  SampleSettings sampling;
  sampling.count = count;
  sampling.seed = seed;
  const std::vector<SurfaceSample> samples = sampleSurface(mesh, sampling);
  // Balls for tissue lie between the surface and a sheet near the medial axis, where there are no Voronoi vertices.
  if (is_soft) return shrinkingBalls(samples, field);
  std::vector<Eigen::Vector3d> points;
  for (const SurfaceSample& s : samples) points.push_back(s.point);
  progress.check();
  std::vector<Ball> pool = voronoiBalls(points, field);
  progress.check();
  // In a solid thinner than the spacing of the samples, Voronoi vertices lie outside and are useless.
  const bool thin = pool.size() < samples.size() / kFewInside;
  const std::vector<Ball> touching = shrinkingBalls(thinned(samples, thin ? samples.size() : effort.touching_samples), field);
  pool.insert(pool.end(), touching.begin(), touching.end());
  return pool;
}

}  // namespace

LevelBalls CoverBuilder::build(const BuildSettings& settings, Progress& progress, std::span<const std::vector<Ball>> start) {
  start_ = start;
  if (settings.quality != quality_ || settings.seed != seed_ || (settings.soft_share > 0) != is_soft_ || pool_.empty()) {
    quality_ = settings.quality;
    seed_ = settings.seed;
    is_soft_ = settings.soft_share > 0;
    pool_samples_ = 0;
    covers_.clear();
    leaves_.clear();
  }
  std::size_t full = 1;
  for (int level = 1; level < settings.levels; ++level) full *= static_cast<std::size_t>(settings.branching);
  const std::size_t budget = settings.max_leaves > 0 ? std::min(full, static_cast<std::size_t>(settings.max_leaves)) : full;
  if (settings.tolerance_mm > 0) return levelsAbove(coverWithin(settings.tolerance_mm, budget, progress), full, settings, progress);
  fitPool(budget, progress);
  return levelsAbove(cover(budget, progress), full, settings, progress);
}

// Makes a pool that is fine enough for `spheres`.
void CoverBuilder::fitPool(std::size_t spheres, Progress& progress) {
  const Effort effort = effortOf(quality_);
  const std::size_t samples = std::max(effort.medial_samples, kMedialSamplesASphere * spheres);
  if (samples > pool_samples_) {
    progress.stage("medial axis");
    pool_ = medialPool(mesh_, field_, samples, effort, seed_, is_soft_, progress);
    pool_samples_ = samples;
    covers_.clear();
    if (pool_.empty()) throw BuildError("no ball fits inside the mesh: it is too thin for double precision, or inside out");
  }
  progress.stage("cover");
}

// The search for `spheres` balls, started from balls of the pool.
CoverSearch CoverBuilder::startSearch(std::size_t spheres, std::uint64_t seed, Progress& progress) const {
  const Effort effort = effortOf(quality_);
  SampleSettings sampling;
  sampling.count = std::max(effort.min_samples, effort.samples_a_sphere * spheres);
  sampling.seed = seed + 1;
  const std::size_t candidates =
      std::max(kMinCandidates, std::min(effort.candidates_a_sphere * spheres, std::max(kManyCandidates, kCandidatesIfMany * spheres)));
  SearchSettings search;
  search.moves = kMovesBeside + static_cast<int>(effort.search_moves * static_cast<double>(spheres));
  search.step = effort.search_step;
  search.work = effort.search_work;
  search.last_step = effort.last_step;
  search.failures = effort.removal_failures;
  search.gap_tolerance = effort.gap_tolerance;
  search.removal_moves = effort.removal_moves;
  const std::vector<SurfaceSample> samples = sampleSurface(mesh_, sampling);
  ChosenBalls start;
  if (start_.empty()) {
    start = chooseBalls(mesh_, field_, samples, thinned(pool_, candidates), spheres, seed + spheres, progress);
  } else {
    start = {startFor(spheres), {}, spheres, seed + spheres};
    for (const SurfaceSample& s : samples) start.samples.push_back(s.point);
  }
  return {mesh_, field_, std::move(start), search, progress};
}

// The level of the given start whose number of balls is nearest to `spheres`, as inscribed balls.
std::vector<Ball> CoverBuilder::startFor(std::size_t spheres) const {
  const auto off = [&](const std::vector<Ball>& level) { return std::max(level.size(), spheres) - std::min(level.size(), spheres); };
  std::vector<Ball> balls = *std::ranges::min_element(start_, {}, off);
  for (Ball& ball : balls) ball.radius = -field_.signedDistance(ball.centre);
  return balls;
}

// The cover with the smallest stand-off that was found for this number of spheres.
const Cover& CoverBuilder::cover(std::size_t spheres, Progress& progress) {
  if (const auto known = covers_.find(spheres); known != covers_.end()) return known->second;
  CoverSearch search = startSearch(spheres, seed_, progress);
  search.lower(0, progress);
  search.close(progress);
  return covers_[spheres] = search.cover();
}

// Estimates the number of leaves for a stand-off from greedy covers of few samples: the stand-off is a power of that
// number.
std::size_t CoverBuilder::guessLeaves(double stand_off, std::size_t max_leaves, Progress& progress) {
  auto guess = static_cast<std::size_t>(std::sqrt(static_cast<double>(max_leaves)));
  for (int round = 0, last = 0; round < kMaxGuesses && last != static_cast<int>(guess); ++round) {
    last = static_cast<int>(guess);
    fitPool(guess, progress);
    SampleSettings sampling;
    sampling.count = std::max<std::size_t>(kRoughSamples * guess, kMinRoughSamples);
    sampling.seed = seed_ + 1;
    const double rough = roughStandOff(field_, sampleSurface(mesh_, sampling), pool_, guess, progress);
    guess = static_cast<std::size_t>(std::clamp(static_cast<double>(guess) * rough / stand_off, 1.0, static_cast<double>(max_leaves)));
  }
  return guess;
}

// The smallest number of leaves found, starting from the leaves of the last tolerance if there was one, otherwise from
// an estimated number.
Cover CoverBuilder::coverWithin(double stand_off, std::size_t max_leaves, Progress& progress) {
  const bool begins = leaves_.empty();
  std::size_t guess = 0;
  if (begins) {
    guess = guessLeaves(stand_off, max_leaves, progress);
    fitPool(guess, progress);
    leaves_ = std::vector<std::optional<CoverSearch>>(effortOf(quality_).starts);
  }
  // Each search ends in a local optimum of its own.
  tbb::parallel_for(std::size_t{0}, leaves_.size(), [&](std::size_t start) {
    if (begins) leaves_[start].emplace(startSearch(guess, seed_ + (std::uint64_t{start} << 32), progress));
    leaves_[start]->fit(stand_off, max_leaves, progress);
  });
  const auto has_fewer = [](const std::optional<CoverSearch>& a, const std::optional<CoverSearch>& b) {
    return std::pair(a->balls().size(), a->standOff()) < std::pair(b->balls().size(), b->standOff());
  };
  Cover smallest = (*std::min_element(leaves_.begin(), leaves_.end(), has_fewer))->cover();
  if (smallest.balls.size() > 1) return smallest;
  // If one ball keeps the tolerance, uses the one with the smallest stand-off. Only for one ball is this worth the
  // time.
  const Cover& lowest = cover(1, progress);
  return lowest.stand_off < smallest.stand_off ? lowest : smallest;
}

/// The levels above `leaves`, each with the largest allowed number of balls; `full`: number of leaves of a full tree.
LevelBalls CoverBuilder::levelsAbove(Cover leaves, std::size_t full, const BuildSettings& settings, Progress& progress) {
  // With a tolerance, only as many spheres above as the leaves need as parents.
  std::vector<std::size_t> counts(static_cast<std::size_t>(settings.levels), 1);
  for (std::size_t level = 1; level < counts.size(); ++level)
    counts[level] = std::min(counts[level - 1] * static_cast<std::size_t>(settings.branching), leaves.balls.size());
  if (leaves.balls.size() < full && (settings.tolerance_mm > 0 || settings.max_leaves > 0))
    counts = levelCounts(leaves.balls.size(), settings.branching);
  std::vector<Cover> covers(counts.size());
  covers.back() = std::move(leaves);
  const std::size_t total = std::accumulate(counts.begin(), counts.end(), std::size_t{0});
  std::size_t done = 0;
  for (std::size_t level = counts.size() - 1; level-- > 0;) {
    done += counts[level + 1];
    progress.advance(static_cast<double>(done) / static_cast<double>(total));  // the time is proportional to the spheres
    covers[level] = cover(std::min(counts[level], covers[level + 1].balls.size()), progress);
  }
  LevelBalls levels;
  for (std::size_t level = 0; level < covers.size(); ++level) {
    // On a round object, eight balls may have a smaller overhang than 64, for each of which less work is spent.
    if (level > 0 && covers[level].stand_off > covers[level - 1].stand_off) covers[level] = covers[level - 1];
    levels.balls.push_back(covers[level].balls);
  }
  return levels;
}

}  // namespace spheretree::builder
