// SPDX-License-Identifier: GPL-3.0-or-later
#include "cover/build_cover.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/run_beside.h"
#include "cover/farthest_points.h"
#include "geometry/surface_samples.h"
#include "tree/hierarchy.h"

namespace spheretree::builder {

namespace {

constexpr int kGuesses = 3;                                      // of the number of leaves for a tolerance, each from a short search
constexpr std::size_t kSamplesASphere = 16, kMinSamples = 1000;  // from which a search starts

struct Effort {
  double search_moves;  // for each sphere
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
      return {.search_moves = 0.4,
              .search_work = 40'000'000,
              .search_step = 0.08,
              .last_step = 0.012,
              .gap_tolerance = 0.03,
              .removal_moves = 8,
              .removal_failures = 5,
              .starts = 1};
    case Quality::Standard:
      return {.search_moves = 0.7,
              .search_work = 80'000'000,
              .search_step = 0.06,
              .last_step = 0.007,
              .gap_tolerance = 0.02,
              .removal_moves = 25,
              .removal_failures = 6,
              .starts = 1};
    case Quality::Best:
      return {.search_moves = 2.2,
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

}  // namespace

LevelBalls CoverBuilder::build(const BuildSettings& settings, Progress& progress, std::span<const std::vector<Ball>> start) {
  start_ = start;
  if (settings.quality != quality_ || settings.seed != seed_) {
    quality_ = settings.quality;
    seed_ = settings.seed;
    covers_.clear();
    leaves_.clear();
  }
  progress.stage("cover");
  std::size_t full = 1;
  for (int level = 1; level < settings.levels; ++level) full *= static_cast<std::size_t>(settings.branching);
  const std::size_t budget = settings.max_leaves > 0 ? std::min(full, static_cast<std::size_t>(settings.max_leaves)) : full;
  // With a tolerance, only as many spheres above as the leaves need as parents.
  std::optional<Cover> leaves;
  if (settings.tolerance_mm > 0) leaves = coverWithin(settings.tolerance_mm, budget, progress);
  const std::size_t count = leaves ? leaves->balls.size() : budget;
  std::vector<std::size_t> counts(static_cast<std::size_t>(settings.levels), 1);
  for (std::size_t level = 1; level < counts.size(); ++level)
    counts[level] = std::min(counts[level - 1] * static_cast<std::size_t>(settings.branching), count);
  if (count < full && (settings.tolerance_mm > 0 || settings.max_leaves > 0)) counts = levelCounts(count, settings.branching);
  return levels(counts, leaves ? &*leaves : nullptr, progress);
}

// The search for `spheres` balls, from farthest points or the given balls.
CoverSearch CoverBuilder::startSearch(std::size_t spheres, std::uint64_t seed, Progress& progress) const {
  const Effort effort = effortOf(quality_);
  SampleSettings sampling;
  sampling.count = std::max(kMinSamples, kSamplesASphere * spheres);
  sampling.seed = seed + 1;
  SearchSettings search;
  search.moves = kMovesBeside + static_cast<int>(effort.search_moves * static_cast<double>(spheres));
  search.step = effort.search_step;
  search.work = effort.search_work;
  search.last_step = effort.last_step;
  search.failures = effort.removal_failures;
  search.gap_tolerance = effort.gap_tolerance;
  search.removal_moves = effort.removal_moves;
  SearchStart start{.count = spheres, .seed = seed + spheres};
  for (const SurfaceSample& s : sampleSurface(mesh_, sampling)) start.samples.push_back(s.point);
  start.balls = start_.empty() ? farthestPointBalls(field_, start.samples, spheres) : startFor(spheres);
  if (start.balls.empty()) throw BuildError("no ball fits inside the mesh: it is too thin for double precision, or inside out");
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
Cover CoverBuilder::newCover(std::size_t spheres, Progress& progress) const {
  CoverSearch search = startSearch(spheres, seed_, progress);
  search.lower(0, progress);
  search.close(progress);
  return search.cover();
}

// Completes covers_ by these numbers of spheres, which ascend. The searches for the smaller ones run beside the last,
// which takes longest.
void CoverBuilder::findCovers(std::span<const std::size_t> counts, Progress& progress) {
  if (counts.empty()) return;
  const std::span<const std::size_t> smaller = counts.first(counts.size() - 1);
  if (covers_.contains(counts.back()) || (!smaller.empty() && smaller.back() == counts.back())) return findCovers(smaller, progress);
  Cover cover;
  runBeside(
      progress, [&] { cover = newCover(counts.back(), progress); }, [&](Progress& part) { findCovers(smaller, part); });
  covers_[counts.back()] = std::move(cover);
}

// The smallest number of leaves found, starting from the leaves of the last tolerance if there was one, otherwise from
// an estimated number.
Cover CoverBuilder::coverWithin(double stand_off, std::size_t max_leaves, Progress& progress) {
  const bool begins = leaves_.empty();
  std::size_t guess = 0;
  if (begins) {
    // The stand-off is about in inverse proportion to the number of balls.
    guess = static_cast<std::size_t>(std::sqrt(static_cast<double>(max_leaves)));
    for (int round = 0; round < kGuesses; ++round) {
      const double needed = static_cast<double>(guess) * startSearch(guess, seed_, progress).standOff() / stand_off;
      guess = static_cast<std::size_t>(std::clamp(needed, 1.0, static_cast<double>(max_leaves)));
    }
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
  findCovers(std::array<std::size_t, 1>{1}, progress);
  const Cover& lowest = covers_[1];
  return lowest.stand_off < smallest.stand_off ? lowest : smallest;
}

// Levels of these numbers of balls, of which the last are `leaves` if they are given.
LevelBalls CoverBuilder::levels(std::span<const std::size_t> counts, const Cover* leaves, Progress& progress) {
  findCovers(leaves ? counts.first(counts.size() - 1) : counts, progress);
  std::vector<Cover> covers;
  for (const std::size_t count : counts) covers.push_back(leaves && covers.size() + 1 == counts.size() ? *leaves : covers_.at(count));
  LevelBalls out;
  for (std::size_t level = 0; level < covers.size(); ++level) {
    // On a round object, eight balls may have a smaller overhang than 64, for each of which less work is spent.
    if (level > 0 && covers[level].stand_off > covers[level - 1].stand_off) covers[level] = covers[level - 1];
    out.balls.push_back(covers[level].balls);
  }
  return out;
}

}  // namespace spheretree::builder
