// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/split_and_drop.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "geometry/sample_index.h"
#include "geometry/smallest_ball.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kWorthwhile = 1e-3;  // smallest relative reduction of an overhang for an exchange
constexpr double kNearWorst = 0.85;   // balls above this share of the worst overhang are split
constexpr double kRelaxed = 0.75;     // below this share of the worst overhang, a refit would gain nothing
constexpr double
    kListedStandOff = 1.05,
    kOutdatedStandOff =
        1.4;  // points of a ball are listed for a stand-off this much larger, and listed again when it is larger by the second factor
constexpr std::size_t kSplitsARound = 16;   // at most one over this of the balls are split in a round
constexpr int kHalvesRounds = 2;            // of refits, after a split
constexpr int kPatience = 5;                // consecutive rounds without gain
constexpr std::size_t kMaxParts = 8;        // largest number of parts of a ball if two halves are no better
constexpr std::size_t kMaxTriedTwice = 16;  // number of balls up to which a start of its own is tried

double gapOf(const Vector3d& p, const FittedBall& b) { return (p - b.centre).norm() - b.clearance; }

double worstOf(std::span<const FittedBall> balls) {
  double worst = 0;
  for (const FittedBall& b : balls) worst = std::max(worst, b.overhang());
  return worst;
}

class Level {
 public:
  Level(const DistanceField& field, std::span<const Vector3d> points, std::vector<FittedBall>& balls, const Progress& progress)
      : field_(field), points_(points), balls_(balls), progress_(progress), first_(points.size()), second_(points.size()) {}

  // Assigns each point to the ball in which it lies deepest, and determines the overhang that the second ball would
  // need. Balls shrink to their points.
  void assign() {
    progress_.check();
    stand_off_ = std::max(worstOf(balls_), 1e-12 * field_.diagonal());
    state_.resize(balls_.size());
    tbb::parallel_for(std::size_t{0}, balls_.size(), [&](std::size_t b) { findWithin(balls_[b], state_[b].within); });
    std::fill(first_.begin(), first_.end(), Holder{});
    std::fill(second_.begin(), second_.end(), Holder{});
    for (std::uint32_t b = 0; b < balls_.size(); ++b)
      for (const Within::Point& p : state_[b].within.points)
        if (p.gap <= stand_off_) look(p.point, {b, p.gap});
    std::vector<std::vector<std::uint32_t>> patch(balls_.size());
    std::vector<double> reach(balls_.size(), 0);
    for (State& s : state_) s.loss = 0;
    for (std::uint32_t i = 0; i < points_.size(); ++i) {
      if (first_[i].ball == kNoParent)  // beyond the stand-off of all balls
        for (std::uint32_t b = 0; b < balls_.size(); ++b) look(i, {b, gapOf(points_[i], balls_[b])});
      const std::uint32_t b = first_[i].ball;
      patch[b].push_back(i);
      state_[b].loss = std::max(state_[b].loss, second_[i].gap);
      reach[b] = std::max(reach[b], first_[i].gap);
    }
    for (std::size_t b = 0; b < balls_.size(); ++b) {
      balls_[b].radius = patch[b].empty() ? 0 : (balls_[b].clearance + reach[b]) * (1 + 1e-12);
      if (patch[b] != state_[b].patch) state_[b].refit_is_useless = state_[b].split_is_useless = false;
      state_[b].patch.swap(patch[b]);
    }
  }

  void removeEmpty() {
    const std::size_t before = balls_.size();
    keep([&](std::size_t b) { return !state_[b].patch.empty(); });
    if (balls_.size() < before) assign();
  }

  double worst() const { return worstOf(balls_); }
  std::size_t count() const { return balls_.size(); }

  // With few balls, none of which can be split alone, a different start may be better: divides all points at once.
  void startAgain(std::size_t max_count) {
    std::vector<Vector3d> all;
    for (std::uint32_t i = 0; i < points_.size(); ++i) all.push_back(points_[i]);
    std::vector<FittedBall> parts = breakUp(all, worst(), max_count);
    if (parts.empty()) return;
    balls_ = std::move(parts);
    state_.clear();
    assign();
    removeEmpty();
  }

  // Removes balls until `max_count` remain, those with the smallest loss first; their neighbours take over the points.
  void shrinkTo(std::size_t max_count) {
    while (balls_.size() > max_count) {
      begin();
      std::size_t wanted = balls_.size() - max_count;
      for (const std::uint32_t b : byLoss()) {
        if (wanted == 0) break;
        if (!touched_[b] && drop(b)) --wanted;
      }
      finish(kRelaxed);
    }
  }

  // One round of exchanges; the other balls with a large overhang are refitted. Returns false if there was no exchange.
  bool exchange(std::size_t max_count, double relaxed) {
    begin();
    const double worst = this->worst();
    std::size_t spare = max_count - balls_.size();
    std::vector<std::uint32_t> wide;
    for (std::uint32_t b = 0; b < balls_.size(); ++b)
      if (balls_[b].overhang() > kNearWorst * worst || (spare > 0 && !state_[b].split_is_useless)) wide.push_back(b);
    std::stable_sort(wide.begin(), wide.end(),
                     [&](std::uint32_t x, std::uint32_t y) { return balls_[x].overhang() > balls_[y].overhang(); });
    const std::size_t batch = std::max<std::size_t>(1, balls_.size() / kSplitsARound);
    if (wide.size() > batch) wide.resize(batch);
    const std::vector<std::uint32_t> cheap = byLoss();
    std::size_t next = 0;
    std::vector<std::vector<FittedBall>> parts(wide.size());
    tbb::parallel_for(std::size_t{0}, wide.size(), [&](std::size_t k) {
      State& s = state_[wide[k]];
      if (!s.split_is_useless) parts[k] = breakUp(wide[k], 2);
      s.split_is_useless = parts[k].empty();
    });
    bool any = false;
    for (std::size_t k = 0; k < wide.size(); ++k) {
      const std::uint32_t b = wide[k];
      if (touched_[b]) continue;
      // Half a cube has a larger overhang than the cube, an octant does not.
      for (std::size_t more = std::min<std::size_t>(spare + 1, kMaxParts); parts[k].empty() && more > 2; --more)
        parts[k] = breakUp(b, more);
      if (parts[k].empty()) continue;
      const std::size_t needed = parts[k].size() - 1;
      touched_[b] = removed_[b] = 1;
      if (needed > spare) {
        for (; next < cheap.size(); ++next) {
          const std::uint32_t d = cheap[next];
          if (state_[d].loss >= worst * (1 - kWorthwhile)) next = cheap.size();
          if (next == cheap.size() || (!touched_[d] && drop(d))) break;
        }
        if (next == cheap.size()) {
          removed_[b] = 0;
          break;
        }
        ++next, ++spare;
      }
      spare -= needed;
      made_.insert(made_.end(), parts[k].begin(), parts[k].end());
      any = true;
    }
    finish(relaxed);
    return any;
  }

 private:
  struct Holder {
    std::uint32_t ball = kNoParent;
    double gap = kInfinity;
  };
  // The points that a ball contains at a stand-off. Searching for them is the main cost of a round, and most balls do
  // not change.
  struct Within {
    struct Point {
      std::uint32_t point;
      double gap;
    };
    Vector3d centre = Vector3d::Zero();
    double stand_off = -1;  // negative: not yet known
    std::vector<Point> points;
  };
  struct State {
    Within within;
    std::vector<std::uint32_t> patch;  // points that lie deepest in the ball
    double loss = 0;                   // the overhang that the others would need without it
    bool refit_is_useless = false;     // a refit to this patch gains nothing
    bool split_is_useless = false;     // halves of this patch are no better
  };

  void findWithin(const FittedBall& ball, Within& within) const {
    if (within.centre == ball.centre && within.stand_off >= stand_off_ && within.stand_off <= kOutdatedStandOff * stand_off_) return;
    within = {ball.centre, kListedStandOff * stand_off_, std::move(within.points)};
    within.points.clear();
    points_.within(ball.centre, ball.clearance + within.stand_off, [&](std::uint32_t i, double distance) {
      within.points.push_back({i, distance - ball.clearance});
    });
  }

  void look(std::uint32_t i, const Holder& h) {
    Holder &first = first_[i], &second = second_[i];
    if (h.gap < first.gap)
      second = first, first = h;
    else if (h.gap < second.gap)
      second = h;
  }

  template <class Keep>
  void keep(Keep is_kept) {
    std::size_t kept = 0;
    for (std::size_t b = 0; b < balls_.size(); ++b) {
      if (!is_kept(b)) continue;
      if (kept < b) balls_[kept] = balls_[b], state_[kept] = std::move(state_[b]);
      ++kept;
    }
    balls_.resize(kept);
    state_.resize(kept);
  }

  std::vector<Vector3d> pointsOf(const std::vector<std::uint32_t>& patch) const {
    std::vector<Vector3d> out;
    out.reserve(patch.size());
    for (const std::uint32_t i : patch) out.push_back(points_[i]);
    return out;
  }

  std::vector<std::uint32_t> byLoss() const {
    std::vector<std::uint32_t> order(balls_.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t x, std::uint32_t y) { return state_[x].loss < state_[y].loss; });
    return order;
  }

  void begin() {
    touched_.assign(balls_.size(), 0);
    removed_.assign(balls_.size(), 0);
    inherits_.assign(balls_.size(), 0);
    made_.clear();
  }

  // Returns false if a ball that would have to take over is itself about to change.
  bool drop(std::uint32_t b) {
    for (const std::uint32_t i : state_[b].patch)
      if (second_[i].ball != kNoParent && removed_[second_[i].ball]) return false;
    touched_[b] = removed_[b] = 1;
    for (const std::uint32_t i : state_[b].patch) {
      const std::uint32_t heir = second_[i].ball;
      if (heir == kNoParent) continue;  // beyond the stand-off of all balls: the next assignment grows one of them
      touched_[heir] = inherits_[heir] = 1;
      state_[heir].patch.push_back(i);
      state_[heir].refit_is_useless = false;
    }
    return true;
  }

  void finish(double relaxed) {
    const double worst = this->worst();
    tbb::parallel_for(std::size_t{0}, balls_.size(), [&](std::size_t b) {
      if (removed_[b] || state_[b].refit_is_useless || !(inherits_[b] || balls_[b].overhang() > relaxed * worst)) return;
      const double before = balls_[b].overhang();
      refitToPatch(field_, pointsOf(state_[b].patch), balls_[b], relaxed * worst);
      state_[b].refit_is_useless = !inherits_[b] && balls_[b].overhang() > before * (1 - kWorthwhile);
    });
    keep([&](std::size_t b) { return !removed_[b]; });
    balls_.insert(balls_.end(), made_.begin(), made_.end());
    assign();
  }

  std::vector<FittedBall> breakUp(std::uint32_t b, std::size_t parts) const {
    return breakUp(pointsOf(state_[b].patch), balls_[b].overhang(), parts);
  }

  // Balls for the parts of a patch: each point goes to the nearest of some points that are far from each other. Empty
  // if their overhang is not smaller.
  std::vector<FittedBall> breakUp(std::span<const Vector3d> own, double overhang, std::size_t parts) const {
    const std::vector<Vector3d> ends = farthestFirst(own, parts);
    if (own.size() <= parts) return {};
    std::vector<std::vector<Vector3d>> part(parts);
    for (const Vector3d& p : own) {
      std::size_t nearest = 0;
      for (std::size_t k = 1; k < parts; ++k)
        if ((p - ends[k]).squaredNorm() < (p - ends[nearest]).squaredNorm()) nearest = k;
      part[nearest].push_back(p);
    }
    std::vector<FittedBall> halves;
    for (const auto& points : part) {
      if (points.empty()) continue;
      const Ball smallest = smallestBall(points);
      halves.push_back({smallest.centre, smallest.radius, -field_.signedDistance(smallest.centre)});
    }
    refitBalls(field_, own, halves, kHalvesRounds, progress_);
    if (worstOf(halves) >= overhang * (1 - kWorthwhile)) return {};
    return halves;
  }

  const DistanceField& field_;
  SampleIndex points_;
  std::vector<FittedBall>& balls_;
  const Progress& progress_;
  double stand_off_ = 0;
  std::vector<Holder> first_, second_;
  std::vector<State> state_;                        // (balls)
  std::vector<char> touched_, inherits_, removed_;  // (balls) in this round: part of an exchange; gets points; removed
  std::vector<FittedBall> made_;
};

}  // namespace

void splitAndDrop(const DistanceField& field, std::span<const Vector3d> points, std::vector<FittedBall>& balls,
                  const SplitAndDropSettings& settings, const Progress& progress) {
  if (points.empty() || balls.empty()) throw std::invalid_argument("split and drop: no points or no balls");
  Level level(field, points, balls, progress);
  level.assign();
  level.removeEmpty();
  level.shrinkTo(settings.max_balls);
  if (settings.max_balls > 1 && settings.max_balls <= kMaxTriedTwice && settings.max_rounds > 0 && level.worst() > settings.target_overhang)
    level.startAgain(settings.max_balls);
  double before = level.worst();
  for (int round = 0, rounds_without_gain = 0;
       round < settings.max_rounds && rounds_without_gain < kPatience && level.worst() > settings.target_overhang;) {
    const std::size_t count = level.count();
    const bool exchanged = level.exchange(settings.max_balls, rounds_without_gain > 0 ? 0 : kRelaxed);  // without gain, all balls move
    const double now = level.worst();
    const bool grown = level.count() > count;  // what is free is used up first
    if (!grown) ++round;
    rounds_without_gain = grown || now < before * (1 - kWorthwhile) ? 0 : rounds_without_gain + 1;
    if (!exchanged && rounds_without_gain > 1) break;
    before = std::min(before, now);
  }
  level.removeEmpty();
}

}  // namespace spheretree::builder
