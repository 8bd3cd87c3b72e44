// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/optimise_cover.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <queue>
#include <random>
#include <stdexcept>

#include "open_set.h"
#include "spheretree/builder/refit_ball.h"
#include "spheretree/builder/sample_index.h"
#include "spheretree/builder/shrinking_balls.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr int kBisections = 4;                    // of the greedy cover: what is left of the interval, the later steps take in their stride
constexpr double kDry = 0.4;                      // share of the stand-off: a sample that no candidate comes so near to holds the search up
constexpr int kMostTopUps = 9;                    // of the candidates where they are dry, each with a new greedy cover
constexpr double kFull = 0.9;                     // share of the spheres that a greedy cover uses where candidates suffice
constexpr std::size_t kDenser = 8;                // times the samples, of which those are taken that lie where balls have few
constexpr std::size_t kMostEntries = 25'000'000;  // of a gap table, 16 bytes each: else very slender or deep trees fill the memory
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Which candidate covers which sample at which stand-off: the entries with gap = |p - c| - d(c) <= limit, by candidate and by
// sample. Float gaps order the search only; what is returned is computed in double.
class GapTable {
 public:
  struct Entry {
    std::uint32_t id;
    float gap;
  };

  GapTable(const SampleIndex& samples, std::span<const Ball> candidates, double limit) {
    const std::size_t n = candidates.size();
    constexpr std::size_t kChunk = 64;
    const std::size_t chunks = (n + kChunk - 1) / kChunk;
    std::vector<std::vector<Entry>> found(chunks);
    std::vector<std::uint32_t> count(n, 0);
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
      for (std::size_t c = chunk * kChunk; c < std::min(n, (chunk + 1) * kChunk); ++c) {
        const std::size_t before = found[chunk].size();
        samples.within(candidates[c].centre, candidates[c].radius + limit, [&](std::uint32_t i, double distance) {
          found[chunk].push_back({static_cast<std::uint32_t>(i), static_cast<float>(distance - candidates[c].radius)});
        });
        count[c] = static_cast<std::uint32_t>(found[chunk].size() - before);
      }
    });
    candidate_begin_.assign(n + 1, 0);
    for (std::size_t c = 0; c < n; ++c) candidate_begin_[c + 1] = candidate_begin_[c] + count[c];
    by_candidate_.resize(candidate_begin_[n]);
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
      std::copy(found[chunk].begin(), found[chunk].end(),
                by_candidate_.begin() + static_cast<std::ptrdiff_t>(candidate_begin_[chunk * kChunk]));
      found[chunk] = {};
    });
    transpose(samples.size());
  }

  std::size_t candidates() const { return candidate_begin_.size() - 1; }
  std::size_t samples() const { return sample_begin_.size() - 1; }
  std::span<const Entry> ofCandidate(std::size_t c) const { return span(by_candidate_, candidate_begin_, c); }
  std::span<const Entry> ofSample(std::size_t s) const { return span(by_sample_, sample_begin_, s); }

  // Forgets the entries with a gap above `limit`.
  void restrict(float limit) {
    compact(by_candidate_, candidate_begin_, limit);
    compact(by_sample_, sample_begin_, limit);
  }

 private:
  static std::span<const Entry> span(const std::vector<Entry>& entries, const std::vector<std::size_t>& begin, std::size_t i) {
    return {entries.data() + begin[i], begin[i + 1] - begin[i]};
  }
  static void compact(std::vector<Entry>& entries, std::vector<std::size_t>& begin, float limit) {
    std::size_t to = 0, from = 0;
    for (std::size_t i = 0; i + 1 < begin.size(); ++i) {
      const std::size_t end = begin[i + 1];
      begin[i] = to;
      for (; from < end; ++from)
        if (entries[from].gap <= limit) entries[to++] = entries[from];
    }
    begin.back() = to;
    entries.resize(to);
  }
  void transpose(std::size_t samples) {
    sample_begin_.assign(samples + 1, 0);
    for (const Entry& e : by_candidate_) ++sample_begin_[e.id + 1];
    for (std::size_t s = 0; s < samples; ++s) sample_begin_[s + 1] += sample_begin_[s];
    by_sample_.resize(by_candidate_.size());
    std::vector<std::size_t> at(sample_begin_.begin(), sample_begin_.end() - 1);
    for (std::size_t c = 0; c + 1 < candidate_begin_.size(); ++c)
      for (std::size_t k = candidate_begin_[c]; k < candidate_begin_[c + 1]; ++k)
        by_sample_[at[by_candidate_[k].id]++] = {static_cast<std::uint32_t>(c), by_candidate_[k].gap};
  }

  std::vector<std::size_t> candidate_begin_, sample_begin_;
  std::vector<Entry> by_candidate_, by_sample_;
};

// Takes candidates out, evenly but none of the first `fixed`, until a gap table up to `limit` has no more than about kMostEntries.
void thinToFit(const SampleIndex& samples, double limit, std::size_t fixed, std::vector<Ball>& candidates) {
  constexpr std::size_t kStride = 64;
  std::size_t entries = 0;
  for (std::size_t c = 0; c < candidates.size(); c += kStride)
    samples.within(candidates[c].centre, candidates[c].radius + limit, [&](std::uint32_t, double) { ++entries; });
  const std::size_t every = 1 + kStride * entries / kMostEntries;
  if (every == 1) return;
  std::size_t kept = fixed;
  for (std::size_t c = fixed; c < candidates.size(); c += every) candidates[kept++] = candidates[c];
  candidates.resize(kept);
}

// Lazy greedy set cover at stand-off `h`. Empty if more than `most` sets would be needed. Ties go to the lower candidate.
std::vector<std::uint32_t> greedyCover(const GapTable& table, float h, std::size_t most) {
  struct Gain {
    std::uint32_t gain, candidate;
    bool operator<(const Gain& o) const { return gain != o.gain ? gain < o.gain : candidate > o.candidate; }
  };
  std::vector<Gain> heap(table.candidates());
  for (std::size_t c = 0; c < heap.size(); ++c) {
    std::uint32_t gain = 0;
    for (const GapTable::Entry& e : table.ofCandidate(c)) gain += e.gap <= h;
    heap[c] = {gain, static_cast<std::uint32_t>(c)};
  }
  std::priority_queue<Gain> queue(std::less<Gain>(), std::move(heap));
  std::vector<char> covered(table.samples(), 0);
  std::size_t open = table.samples();
  std::vector<std::uint32_t> chosen;
  while (open > 0) {
    if (queue.empty() || chosen.size() == most) return {};
    Gain top = queue.top();
    queue.pop();
    if (top.gain == 0) return {};
    std::uint32_t gain = 0;
    for (const GapTable::Entry& e : table.ofCandidate(top.candidate)) gain += e.gap <= h && !covered[e.id];
    if (gain < top.gain) {
      if (gain > 0) queue.push({gain, top.candidate});
      continue;
    }
    for (const GapTable::Entry& e : table.ofCandidate(top.candidate))
      if (e.gap <= h && !covered[e.id]) covered[e.id] = 1, --open;
    chosen.push_back(top.candidate);
  }
  return chosen;
}

// Weighting local search for set covering. Paper: C. Gao, X. Yao, T. Weise, J. Li. An efficient local search heuristic with row
// weighting for the unicost set covering problem. EJOR 246(3), 2015. Here the number of sets is fixed and the stand-off falls:
// whenever every sample is covered, the sets shrink until one is not.
class SwapSearch {
 public:
  SwapSearch(GapTable& table, std::vector<std::uint32_t> chosen, std::uint64_t seed)
      : table_(table),
        chosen_(std::move(chosen)),
        selected_(table.candidates(), 0),
        weight_(table.samples(), 1),
        stamp_(table.candidates(), 0),
        random_(seed) {
    for (const std::uint32_t c : chosen_) selected_[c] = 1;
  }

  // Best cover found before `work` entries of the table were touched, starting at stand-off `h`; `spheres` sets are used, no more.
  std::vector<std::uint32_t> run(float h, std::size_t spheres, std::uint64_t work, const Progress& progress) {
    std::vector<std::uint32_t> best = chosen_;
    restart(h);
    std::int64_t clock = 0;
    for (std::uint64_t step = 0; touched_ < work; ++step) {
      if (step % 256 == 0) progress.check();
      while (open_.empty()) {
        best = chosen_;
        restart(nextStandOff());
      }
      if (chosen_.size() >= spheres) remove(leastUseful(), ++clock);
      const std::uint32_t sample = open_.anyOf(random_());
      const std::uint32_t candidate = mostUseful(sample);
      if (candidate == kNone) return best;  // no candidate reaches this sample at this stand-off
      add(candidate, ++clock);
      last_added_ = candidate;
      for (const std::uint32_t s : open_) {
        ++weight_[s];
        touched_ += table_.ofSample(s).size();
        for (const GapTable::Entry& e : table_.ofSample(s)) score_[e.id] += e.gap <= h_;
      }
    }
    if (open_.empty()) best = chosen_;
    return best;
  }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  // A little below the largest gap of the present cover.
  float nextStandOff() {
    least_.assign(table_.samples(), std::numeric_limits<float>::infinity());
    for (const std::uint32_t c : chosen_)
      for (const GapTable::Entry& e : table_.ofCandidate(c)) least_[e.id] = std::min(least_[e.id], e.gap);
    const float most = *std::max_element(least_.begin(), least_.end());
    return most - 0.004f * std::abs(most);
  }

  // Counts again at stand-off `h`. Only samples that no set or one set covers matter to a score, so that this costs the entries of
  // the chosen sets, not the table. Entries above the limit stay in the table until enough of them are there to be worth the pass.
  void restart(float h) {
    touched_ += table_.samples() + table_.candidates();
    if (h < 0.97f * restricted_) {
      table_.restrict(h);
      restricted_ = h;
    }
    h_ = h;
    cover_.assign(table_.samples(), 0);
    open_.reset(table_.samples());
    for (const std::uint32_t c : chosen_)
      for (const GapTable::Entry& e : table_.ofCandidate(c)) cover_[e.id] += e.gap <= h_;
    score_.assign(table_.candidates(), 0);
    for (std::uint32_t s = 0; s < cover_.size(); ++s) {
      if (cover_[s] > 0) continue;
      open_.insert(s);
      for (const GapTable::Entry& e : table_.ofSample(s))
        if (e.gap <= h_) score_[e.id] += weight_[s];
    }
    for (const std::uint32_t c : chosen_)
      for (const GapTable::Entry& e : table_.ofCandidate(c))
        if (e.gap <= h_ && cover_[e.id] == 1) score_[c] += weight_[e.id];
  }
  // score: what an unselected set would newly cover, what a selected one alone covers.
  std::size_t leastUseful() const {
    std::size_t best = kNone;
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      const std::uint32_t c = chosen_[i];
      if (c == last_added_) continue;
      if (best == kNone || score_[c] < score_[chosen_[best]] || (score_[c] == score_[chosen_[best]] && stamp_[c] < stamp_[chosen_[best]]))
        best = i;
    }
    return best == kNone ? 0 : best;
  }
  std::uint32_t mostUseful(std::uint32_t sample) const {
    std::uint32_t best = kNone;
    for (const GapTable::Entry& e : table_.ofSample(sample)) {
      if (e.gap > h_ || selected_[e.id] || e.id == last_removed_) continue;
      if (best == kNone || score_[e.id] > score_[best] || (score_[e.id] == score_[best] && stamp_[e.id] < stamp_[best])) best = e.id;
    }
    if (best == kNone)
      for (const GapTable::Entry& e : table_.ofSample(sample))
        if (e.gap <= h_ && !selected_[e.id]) best = e.id;
    return best;
  }

  void remove(std::size_t index, std::int64_t clock) {
    const std::uint32_t c = chosen_[index];
    chosen_[index] = chosen_.back();
    chosen_.pop_back();
    selected_[c] = 0;
    stamp_[c] = clock;
    last_removed_ = c;
    touched_ += table_.ofCandidate(c).size();
    for (const GapTable::Entry& e : table_.ofCandidate(c)) {
      const std::uint32_t s = e.id;
      if (e.gap > h_) continue;
      if (--cover_[s] == 0) {
        touched_ += table_.ofSample(s).size();
        for (const GapTable::Entry& other : table_.ofSample(s))
          if (other.id != c && other.gap <= h_) score_[other.id] += weight_[s];
        open_.insert(s);
      } else if (cover_[s] == 1) {
        for (const GapTable::Entry& other : table_.ofSample(s))
          if (other.gap <= h_ && selected_[other.id]) {
            score_[other.id] += weight_[s];
            break;
          }
      }
    }
  }
  void add(std::uint32_t c, std::int64_t clock) {
    touched_ += table_.ofCandidate(c).size();
    for (const GapTable::Entry& e : table_.ofCandidate(c)) {
      const std::uint32_t s = e.id;
      if (e.gap > h_) continue;
      if (++cover_[s] == 1) {
        touched_ += table_.ofSample(s).size();
        for (const GapTable::Entry& other : table_.ofSample(s))
          if (other.id != c && other.gap <= h_) score_[other.id] -= weight_[s];
        open_.erase(s);
      } else if (cover_[s] == 2) {
        for (const GapTable::Entry& other : table_.ofSample(s))
          if (other.gap <= h_ && selected_[other.id]) {
            score_[other.id] -= weight_[s];
            break;
          }
      }
    }
    selected_[c] = 1;
    stamp_[c] = clock;
    chosen_.push_back(c);
  }

  GapTable& table_;
  std::vector<std::uint32_t> chosen_;
  std::vector<char> selected_;
  std::vector<std::int64_t> weight_, score_, stamp_;
  std::vector<float> least_;
  std::vector<std::uint32_t> cover_;
  OpenSet open_;  // samples that no set covers
  std::uint64_t touched_ = 0;
  float h_ = 0, restricted_ = std::numeric_limits<float>::infinity();
  std::uint32_t last_added_ = kNone, last_removed_ = kNone;
  std::mt19937_64 random_;
};

struct Assignment {
  std::vector<Vector3d> points;    // samples, those of one ball together
  std::vector<std::size_t> begin;  // (balls + 1)
  double stand_off = 0;            // largest gap
  std::span<const Vector3d> patch(std::size_t b) const { return {points.data() + begin[b], begin[b + 1] - begin[b]}; }
};

// Each sample goes to the ball that it lies in deepest: the least |p - c| - d(c). `reach`: a stand-off at which the balls (radius
// d) cover every sample; it is doubled as often as that proves wrong.
Assignment assign(const SampleIndex& samples, std::span<const Ball> balls, double reach) {
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> owner(samples.size());
  std::vector<double> gap(samples.size());
  for (bool all = false; !all; reach *= 2) {
    std::fill(owner.begin(), owner.end(), kNone);
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
    all = std::find(owner.begin(), owner.end(), kNone) == owner.end();
  }
  Assignment out;
  out.begin.assign(balls.size() + 1, 0);
  for (const std::uint32_t b : owner) ++out.begin[b + 1];
  for (std::size_t b = 0; b < balls.size(); ++b) out.begin[b + 1] += out.begin[b];
  out.points.resize(samples.size());
  std::vector<std::size_t> at(out.begin.begin(), out.begin.end() - 1);
  for (std::size_t i = 0; i < samples.size(); ++i) out.points[at[owner[i]]++] = samples[i];
  out.stand_off = *std::max_element(gap.begin(), gap.end());
  return out;
}

// Passes of assignment and refit; keeps the best set of balls seen. `balls` have radius d(c).
double refitAll(const DistanceField& field, const SampleIndex& samples, std::vector<Ball>& balls, double stand_off, int passes,
                const Progress& progress) {
  std::vector<Ball> now = balls;
  double best = stand_off, reach = stand_off;
  for (int pass = 0; pass <= passes; ++pass) {
    progress.check();
    const Assignment patches = assign(samples, now, reach);
    reach = patches.stand_off;
    if (patches.stand_off < best || pass == 0) {
      best = patches.stand_off;
      balls = now;
    }
    if (pass == passes) break;
    tbb::parallel_for(std::size_t{0}, now.size(), [&](std::size_t b) {
      const auto patch = patches.patch(b);
      if (patch.empty()) return;
      const double width = std::sqrt(reach * (2 * std::max(now[b].radius, 0.0) + reach));
      const Refit refit = refitBall(field, patch, now[b].centre, now[b].radius, 0.2 * width, 12);
      now[b] = {refit.centre, refit.clearance};
    });
  }
  return best;
}

// Centres below a sharp convex edge or corner at `point`. A ball that reaches an edge best has its centre about the stand-off deep,
// where the medial axis that samples find is too thin to hold a choice.
void addBelow(const DistanceField& field, const Vector3d& point, const Vector3d& normal, double stand_off, std::vector<Ball>& candidates) {
  for (const double depth : {0.6, 1.0, 1.6, 2.5}) {
    const Vector3d c = point - depth * stand_off * normal;
    const double clearance = -field.signedDistance(c);
    if (clearance > 0) candidates.push_back({c, clearance});
  }
}

// More candidates at the samples that no candidate comes near to: the ball that touches the surface there or, at an edge, smaller
// ones below it. On a slender part the pool may hold none that reaches an end; without them the search would stop there, with most of
// its spheres idle.
void addWhereDry(const DistanceField& field, const SampleIndex& samples, const GapTable& table, double stand_off,
                 std::vector<Ball>& candidates) {
  std::vector<std::uint32_t> dry;
  for (std::uint32_t s = 0; s < samples.size(); ++s) {
    const auto near = [&](const GapTable::Entry& e) { return e.gap <= kDry * stand_off; };
    if (std::ranges::none_of(table.ofSample(s), near)) dry.push_back(s);
  }
  std::vector<std::vector<Ball>> found(dry.size());
  tbb::parallel_for(std::size_t{0}, dry.size(), [&](std::size_t i) {
    const NearestPoint here = field.nearest(samples[dry[i]]);
    const Vector3d normal = field.pseudonormal(here);
    const Ball touching = shrinkingBall(field, here.point, normal);
    if (touching.radius > 0)
      found[i].push_back(touching);
    else
      addBelow(field, here.point, normal, kDry * stand_off, found[i]);
  });
  for (const std::vector<Ball>& balls : found) candidates.insert(candidates.end(), balls.begin(), balls.end());
}

// More samples for balls that have fewer than half of `wanted`: at a cap of a long cylinder, an area small for its need of spheres,
// samples uniform by area would leave a ball with one. Empty if no more than a quarter of the balls are so poor.
std::vector<Vector3d> samplesWhereFew(const TriangleMesh& mesh, const SampleIndex& samples, std::span<const Ball> balls, double stand_off,
                                      std::size_t wanted, std::uint64_t seed) {
  const Assignment patches = assign(samples, balls, stand_off);
  std::size_t poor = 0;
  for (std::size_t b = 0; b < balls.size(); ++b) poor += patches.patch(b).size() < wanted / 2;
  if (poor <= balls.size() / 4) return {};
  SampleSettings sampling;
  sampling.count = kDenser * samples.size();
  sampling.seed = seed;
  std::vector<Vector3d> dense;
  for (const SurfaceSample& s : sampleSurface(mesh, sampling)) dense.push_back(s.point);
  const Assignment more = assign(SampleIndex(dense), balls, stand_off);
  std::vector<Vector3d> added;
  for (std::size_t b = 0; b < balls.size(); ++b) {
    const std::size_t has = patches.patch(b).size();
    if (has >= wanted) continue;
    const auto patch = more.patch(b);
    const std::size_t few = std::min(wanted - has, patch.size());
    for (std::size_t i = 0; i < few; ++i) added.push_back(patch[i * patch.size() / few]);
  }
  return added;
}

// The greedy cover of least stand-off, found by bisection between `low` and `high`; the table must hold all gaps up to `high`. Empty if
// not even that suffices.
struct Greedy {
  std::vector<std::uint32_t> chosen;
  double stand_off;
};
Greedy bisectGreedy(const GapTable& table, double low, double high, std::size_t most, int steps, const Progress& progress) {
  Greedy best{greedyCover(table, static_cast<float>(high), most), high};
  for (int i = 0; i < steps && !best.chosen.empty(); ++i) {
    progress.check();
    const double middle = 0.5 * (low + best.stand_off);
    std::vector<std::uint32_t> chosen = greedyCover(table, static_cast<float>(middle), most);
    if (chosen.empty()) {
      low = middle;
    } else {
      best = {std::move(chosen), middle};
    }
  }
  return best;
}

// The balls of a greedy cover of at most `most` candidates, near stand-off `h` or, if that is not enough, above; and `h` of it. Candidates
// are added where they are dry: returns how many.
std::size_t greedyBalls(const DistanceField& field, const SampleIndex& samples, std::size_t most, double low, double& h,
                        std::vector<Ball>& candidates, std::vector<Ball>& balls, const Progress& progress) {
  for (double high = 1.05 * h;; low = high, high *= 1.3) {
    thinToFit(samples, high, 0, candidates);
    const GapTable table(samples, candidates, high);
    const Greedy greedy = bisectGreedy(table, low, high, most, kBisections, progress);
    if (greedy.chosen.empty()) continue;
    balls.clear();
    for (const std::uint32_t c : greedy.chosen) balls.push_back(candidates[c]);
    h = greedy.stand_off;
    const std::size_t known = candidates.size();
    // The fewer spheres that took, the lower the stand-off of all of them will be.
    addWhereDry(field, samples, table, h * static_cast<double>(balls.size()) / static_cast<double>(most), candidates);
    return candidates.size() - known;
  }
}

template <class T>
std::vector<T> everyNth(std::span<const T> all, std::size_t wanted) {
  const std::size_t n = std::max<std::size_t>(1, all.size() / std::max<std::size_t>(wanted, 1));
  std::vector<T> few;
  for (std::size_t i = 0; i < all.size(); i += n) few.push_back(all[i]);
  return few;
}

}  // namespace

Cover optimiseCover(const TriangleMesh& mesh, const DistanceField& field, std::span<const SurfaceSample> given, std::span<const Ball> pool,
                    const CoverSettings& settings, Progress& progress) {
  if (given.empty()) throw std::invalid_argument("optimise cover: no samples");
  if (pool.empty()) throw std::invalid_argument("optimise cover: no candidates");
  const std::size_t n = std::max<std::size_t>(settings.spheres, 1);
  std::vector<Vector3d> points;
  for (const SurfaceSample& s : given) points.push_back(s.point);
  std::vector<Ball> candidates(pool.begin(), pool.end());

  // A first stand-off from a thinned problem, so that the full table is not larger than it needs to be.
  double h = 0;
  {
    const std::size_t few = std::max<std::size_t>(10 * n, 500);
    const SampleIndex samples(everyNth<Vector3d>(points, few));
    const std::vector<Ball> some = everyNth<Ball>(candidates, few);
    // The stand-off falls about as 1/n. Too high a start costs memory: every candidate would reach every sample.
    const double start = 0.01 * field.diagonal() * std::min(1.0, 512 / static_cast<double>(n));
    for (double low = 0, high = start; h == 0; low = high, high *= 2) {
      const Greedy greedy = bisectGreedy(GapTable(samples, some, high), low, high, n, kBisections, progress);
      if (!greedy.chosen.empty()) h = greedy.stand_off;
    }
  }
  for (const SurfaceSample& s : given)
    if (s.feature) addBelow(field, s.point, s.normal, h, candidates);

  std::mt19937_64 random(settings.seed);
  SampleIndex samples(points);
  std::vector<Ball> balls;
  for (int top_up = 0; top_up <= kMostTopUps; ++top_up) {
    const std::size_t added = greedyBalls(field, samples, n, top_up == 0 ? 0.5 * h : 0.25 * h, h, candidates, balls, progress);
    const bool was_dry = added > 0 && static_cast<double>(balls.size()) < kFull * static_cast<double>(n);
    const std::vector<Vector3d> more = samplesWhereFew(mesh, samples, balls, h, given.size() / n, random());
    if (more.empty() && !was_dry) break;
    if (more.empty()) continue;
    points.insert(points.end(), more.begin(), more.end());
    samples = SampleIndex(points);
  }

  for (int round = 0; round < settings.rounds; ++round) {
    std::vector<Ball> all = balls;  // the present balls are candidates too, in front
    all.insert(all.end(), candidates.begin(), candidates.end());
    thinToFit(samples, h, balls.size(), all);
    GapTable table(samples, all, h);
    std::vector<std::uint32_t> chosen(balls.size());
    std::iota(chosen.begin(), chosen.end(), 0u);
    SwapSearch search(table, std::move(chosen), random());
    chosen = search.run(static_cast<float>(h * (1 - 0.002)), n, settings.swap_work, progress);
    balls.clear();
    for (const std::uint32_t c : chosen) balls.push_back(all[c]);
    h = refitAll(field, samples, balls, assign(samples, balls, h).stand_off, settings.refits, progress);
  }

  // Spheres left over start as copies, which the next step is free to send wherever one is missed most.
  for (std::size_t i = 0; balls.size() < n; ++i) balls.push_back(balls[i]);
  SqueezeSettings squeeze = settings.squeeze;
  squeeze.seed = random();
  Cover cover;
  cover.stand_off = squeezeCover(mesh, field, points, balls, squeeze, progress);
  for (const Ball& b : balls) cover.balls.push_back({b.centre, b.radius + cover.stand_off});
  return cover;
}

}  // namespace spheretree::builder
