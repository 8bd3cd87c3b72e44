// SPDX-License-Identifier: GPL-3.0-or-later
#include "cover/choose_balls.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <stdexcept>

#include "cover/gap_table.h"
#include "geometry/sample_index.h"
#include "medial/shrinking_balls.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr int kBisections = 4;               // of the greedy cover; more are not needed, because later steps improve the result anyway
constexpr double kUncoverableShare = 0.4;    // share of the stand-off: a sample without a candidate this near limits the search
constexpr int kMaxTopUps = 9;                // rounds that add candidates at uncoverable samples, each with a new greedy cover
constexpr std::size_t kMaxTopUpSamples = 8;  // for each sphere: samples that get a candidate of their own in one top-up
constexpr double kGoalGrowth =
    1.3;  // of the stand-off if it is too low; the factor is applied again each time, since the estimate from one sphere is far too low
constexpr double kFull = 0.9;             // share of the spheres that a greedy cover uses if the candidates suffice
constexpr double kFirstGoalFactor = 1.2;  // first goal, as a multiple of the stand-off that the number of unused spheres suggests
constexpr std::size_t kDenser = 8;        // times as many samples, from which those of balls with few samples are taken
constexpr double kHexagon = 2.598;        // area of the largest cell of a flat spot, divided by the square of the spot's radius (Kershner)
constexpr double kMaxSamples = 3;         // times the usual number, for a ball whose patch is a ring
constexpr std::array<double, 4> kEdgeDepths{0.6, 1.0, 1.6, 2.5};  // of candidates below an edge, as multiples of the stand-off
constexpr std::size_t kTooFew = 2;                  // a ball has too few samples if it has less than one over this of what it needs
constexpr std::size_t kSparse = 4;                  // samples are added if more than one over this of the balls have too few
constexpr double kUpperEnd = 1.05;                  // upper end of the first bisection, as a multiple of the estimated stand-off
constexpr double kFirstLow = 0.5, kNextLow = 0.25;  // lower end of the bisection, likewise: of the first greedy cover, and after a top-up
constexpr double kRoughStart = 0.01;                // first goal of a rough cover, as a share of the diagonal ...
constexpr double kRoughSpheres = 512;               // ... for up to this number of spheres; for more in inverse proportion

template <class T>
std::vector<T> everyNth(std::span<const T> all, std::size_t wanted) {
  const std::size_t n = std::max<std::size_t>(1, all.size() / std::max<std::size_t>(wanted, 1));
  std::vector<T> thinned;
  for (std::size_t i = 0; i < all.size(); i += n) thinned.push_back(all[i]);
  return thinned;
}

struct Assignment {
  std::vector<Vector3d> points;    // samples, grouped by ball
  std::vector<std::size_t> begin;  // (balls + 1)
  std::span<const Vector3d> patch(std::size_t b) const { return {points.data() + begin[b], begin[b + 1] - begin[b]}; }
};

// Assigns each sample to the ball in which it lies deepest (smallest |p - c| - d(c)). `reach`: a stand-off at which the
// balls (radius d) should cover every sample; it is doubled until they do.
Assignment assign(const SampleIndex& samples, std::span<const Ball> balls, double reach) {
  constexpr std::uint32_t kNobody = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> owner(samples.size());
  std::vector<double> gap(samples.size());
  for (bool all = false; !all; reach *= 2) {
    std::fill(owner.begin(), owner.end(), kNobody);
    std::fill(gap.begin(), gap.end(), kInfinity);
    struct Hit {
      std::uint32_t sample;
      double gap;
    };
    std::vector<std::vector<Hit>> hits(balls.size());
    tbb::parallel_for(std::size_t{0}, balls.size(), [&](std::size_t b) {
      samples.within(balls[b].centre, std::max(0.0, balls[b].radius + reach) * (1 + 1e-12), [&](std::uint32_t i, double distance) {
        hits[b].push_back({static_cast<std::uint32_t>(i), distance - balls[b].radius});
      });
    });
    for (std::size_t b = 0; b < balls.size(); ++b)
      for (const Hit& hit : hits[b])
        if (hit.gap < gap[hit.sample]) gap[hit.sample] = hit.gap, owner[hit.sample] = static_cast<std::uint32_t>(b);
    all = std::find(owner.begin(), owner.end(), kNobody) == owner.end();
  }
  Assignment out;
  out.begin.assign(balls.size() + 1, 0);
  for (const std::uint32_t b : owner) ++out.begin[b + 1];
  for (std::size_t b = 0; b < balls.size(); ++b) out.begin[b + 1] += out.begin[b];
  out.points.resize(samples.size());
  std::vector<std::size_t> at(out.begin.begin(), out.begin.end() - 1);
  for (std::size_t i = 0; i < samples.size(); ++i) out.points[at[owner[i]]++] = samples[i];
  return out;
}

// Adds centres below a sharp convex edge or corner at `point`. The best ball for an edge has its centre about the
// stand-off deep, where the medial axis of the samples is too thin to offer candidates.
void addBelow(const DistanceField& field, const Vector3d& point, const Vector3d& normal, double stand_off, std::vector<Ball>& candidates) {
  for (const double depth : kEdgeDepths) {
    const Vector3d c = point - depth * stand_off * normal;
    const double clearance = -field.signedDistance(c);
    if (clearance > 0) candidates.push_back({c, clearance});
  }
}

// Adds candidates at the samples that have no candidate nearby: the ball that touches the surface there or, at an edge,
// smaller ones below it. On a slender part the pool may have no candidate that reaches an end; without new ones the
// search would stop there, with most of its spheres unused.
void addWhereUncoverable(const DistanceField& field, const SampleIndex& samples, const GapTable& table, double stand_off,
                         std::size_t max_count, std::vector<Ball>& candidates) {
  std::vector<std::uint32_t> uncoverable;
  for (std::uint32_t s = 0; s < samples.size(); ++s) {
    const auto near = [&](const GapTable::Entry& e) { return e.gap <= kUncoverableShare * stand_off; };
    if (std::ranges::none_of(table.ofSample(s), near)) uncoverable.push_back(s);
  }
  uncoverable = everyNth<std::uint32_t>(uncoverable, max_count);
  std::vector<std::vector<Ball>> found(uncoverable.size());
  tbb::parallel_for(std::size_t{0}, uncoverable.size(), [&](std::size_t i) {
    const NearestPoint here = field.nearest(samples[uncoverable[i]]);
    const Vector3d normal = field.pseudonormal(here);
    const Ball touching = shrinkingBall(field, here.point, normal);
    if (touching.radius > 0)
      found[i].push_back(touching);
    else
      addBelow(field, here.point, normal, kUncoverableShare * stand_off, found[i]);
    if (found[i].empty()) found[i].push_back({here.point, 0});  // the point is on a sheet
  });
  for (const std::vector<Ball>& balls : found) candidates.insert(candidates.end(), balls.begin(), balls.end());
}

// More samples for balls that have fewer than half of what they need. A ball that touches the surface in two round
// spots needs `usual`; one that touches along a ring or a band, as in a tube, has a longer patch and needs
// proportionally more. At the cap of a long cylinder, which is small for the number of spheres that it needs, samples
// uniform by area would leave a ball with a single sample. Empty if at most a quarter of the balls have too few.
std::vector<Vector3d> samplesWhereFew(const TriangleMesh& mesh, const SampleIndex& uniform, const SampleIndex& samples,
                                      std::span<const Ball> balls, double stand_off, double area, std::size_t usual, std::uint64_t seed) {
  const Assignment patches = assign(samples, balls, stand_off), shares = assign(uniform, balls, stand_off);
  const double area_of_sample = area / static_cast<double>(uniform.size());
  std::vector<std::size_t> wanted(balls.size());
  std::size_t sparse_count = 0;
  for (std::size_t b = 0; b < balls.size(); ++b) {
    const double square = stand_off * (2 * std::max(balls[b].radius, 0.0) + stand_off);  // of the radius of a round spot
    const double spots = static_cast<double>(shares.patch(b).size()) * area_of_sample / (kHexagon * square);
    wanted[b] = static_cast<std::size_t>(static_cast<double>(usual) * std::clamp(spots / 2, 1.0, kMaxSamples));
    sparse_count += patches.patch(b).size() < wanted[b] / kTooFew;
  }
  if (sparse_count <= balls.size() / kSparse) return {};
  SampleSettings sampling;
  sampling.count = kDenser * samples.size();
  sampling.seed = seed;
  std::vector<Vector3d> dense;
  for (const SurfaceSample& s : sampleSurface(mesh, sampling)) dense.push_back(s.point);
  const Assignment more = assign(SampleIndex(dense), balls, stand_off);
  std::vector<Vector3d> added;
  for (std::size_t b = 0; b < balls.size(); ++b) {
    const std::size_t has = patches.patch(b).size();
    if (has >= wanted[b]) continue;
    const auto patch = more.patch(b);
    const std::size_t count = std::min(wanted[b] - has, patch.size());
    for (std::size_t i = 0; i < count; ++i) added.push_back(patch[i * patch.size() / count]);
  }
  return added;
}

// The greedy cover of smallest stand-off, found by bisection between `low` and `high`; the table must contain all gaps
// up to `high`. Empty if `high` does not suffice either.
struct Greedy {
  std::vector<std::uint32_t> chosen;
  double stand_off;
};
Greedy bisectGreedy(const GapTable& table, double low, double high, std::size_t max_count, int steps, const Progress& progress) {
  Greedy best{greedyCover(table, static_cast<float>(high), max_count), high};
  for (int i = 0; i < steps && !best.chosen.empty(); ++i) {
    progress.check();
    const double middle = 0.5 * (low + best.stand_off);
    std::vector<std::uint32_t> chosen = greedyCover(table, static_cast<float>(middle), max_count);
    if (chosen.empty()) {
      low = middle;
    } else {
      best = {std::move(chosen), middle};
    }
  }
  return best;
}

// The balls of a greedy cover of at most `max_count` candidates, near stand-off `h` or, if that is too small, above;
// sets `h` to its stand-off. Adds candidates at uncoverable samples and returns how many.
std::size_t greedyBalls(const DistanceField& field, const SampleIndex& samples, std::size_t max_count, double low, double& h,
                        std::vector<Ball>& candidates, std::vector<Ball>& balls, const Progress& progress) {
  double rise = kGoalGrowth;
  for (double high = kUpperEnd * h;; low = high, high *= rise, rise *= kGoalGrowth) {
    thinToFit(samples, high, candidates);
    const GapTable table(samples, candidates, high);
    const Greedy greedy = bisectGreedy(table, low, high, max_count, kBisections, progress);
    if (greedy.chosen.empty()) {
      addWhereUncoverable(field, samples, table, high, kMaxTopUpSamples * max_count, candidates);
      continue;
    }
    balls.clear();
    for (const std::uint32_t c : greedy.chosen) balls.push_back(candidates[c]);
    h = greedy.stand_off;
    const std::size_t known = candidates.size();
    // If fewer spheres suffice, the stand-off of all of them will be lower, in proportion.
    addWhereUncoverable(field, samples, table, h * static_cast<double>(balls.size()) / static_cast<double>(max_count),
                        kMaxTopUpSamples * max_count, candidates);
    return candidates.size() - known;
  }
}

// A first stand-off from a subset of samples and candidates, so that the full table is not larger than necessary.
struct RoughCover {
  double stand_off;
  std::size_t spheres;  // number of spheres used
};
RoughCover roughGreedy(const DistanceField& field, std::span<const Vector3d> points, std::span<const Ball> candidates, std::size_t n,
                       const Progress& progress) {
  const std::size_t count = std::max<std::size_t>(kRoughSamples * n, kMinRoughSamples);
  const SampleIndex samples(everyNth<Vector3d>(points, count));
  const std::vector<Ball> some = everyNth<Ball>(candidates, count);
  // The stand-off is roughly proportional to 1/n. A higher start costs memory, since every candidate would reach every
  // sample.
  const double start = kRoughStart * field.diagonal() * std::min(1.0, kRoughSpheres / static_cast<double>(n));
  for (double low = 0, high = start;; low = high, high *= 2) {
    const Greedy greedy = bisectGreedy(GapTable(samples, some, high), low, high, n, kBisections, progress);
    if (!greedy.chosen.empty()) return {greedy.stand_off, greedy.chosen.size()};
  }
}

}  // namespace

ChosenBalls chooseBalls(const TriangleMesh& mesh, const DistanceField& field, std::span<const SurfaceSample> given,
                        std::span<const Ball> pool, std::size_t spheres, std::uint64_t seed, Progress& progress) {
  if (given.empty()) throw std::invalid_argument("choose balls: no samples");
  if (pool.empty()) throw std::invalid_argument("choose balls: no candidates");
  const std::size_t n = std::max<std::size_t>(spheres, 1);
  std::vector<Vector3d> points;
  for (const SurfaceSample& s : given) points.push_back(s.point);
  std::vector<Ball> candidates(pool.begin(), pool.end());

  const auto [rough, used] = roughGreedy(field, points, candidates, n, progress);
  double h = rough;
  for (const SurfaceSample& s : given)
    if (s.feature) addBelow(field, s.point, s.normal, h, candidates);

  // If fewer spheres suffice, the stand-off of all of them will be lower, in proportion; a table for that stand-off
  // costs a fraction.
  h *= std::min(1.0, kFirstGoalFactor * (static_cast<double>(used) / static_cast<double>(n)));
  std::mt19937_64 random(seed);
  const SampleIndex uniform(points);
  SampleIndex samples(points);
  std::vector<Ball> balls;
  for (int top_ups = 0; top_ups <= kMaxTopUps; ++top_ups) {
    const std::size_t added = greedyBalls(field, samples, n, (top_ups == 0 ? kFirstLow : kNextLow) * h, h, candidates, balls, progress);
    const bool was_dry = added > 0 && static_cast<double>(balls.size()) < kFull * static_cast<double>(n);
    const std::vector<Vector3d> more = samplesWhereFew(mesh, uniform, samples, balls, h, field.area(), given.size() / n, random());
    if (more.empty() && !was_dry) break;
    if (more.empty()) continue;
    points.insert(points.end(), more.begin(), more.end());
    samples = SampleIndex(points);
  }

  return {std::move(balls), std::move(points), n, random()};
}

double roughStandOff(const DistanceField& field, std::span<const SurfaceSample> samples, std::span<const Ball> pool, std::size_t spheres,
                     const Progress& progress) {
  std::vector<Vector3d> points;
  for (const SurfaceSample& s : samples) points.push_back(s.point);
  const RoughCover rough = roughGreedy(field, points, pool, std::max<std::size_t>(spheres, 1), progress);
  return rough.stand_off * static_cast<double>(rough.spheres) / static_cast<double>(std::max<std::size_t>(spheres, 1));
}

}  // namespace spheretree::builder
