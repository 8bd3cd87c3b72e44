// SPDX-License-Identifier: GPL-3.0-or-later
#include "cover/lower_stand_off.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "cover/gap_sampler.h"
#include "cover/uncovered_set.h"
#include "geometry/sample_index.h"
#include "medial/refit_ball.h"
#include "medial/shrinking_balls.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t kAsked = 6;  // balls asked to take a point
constexpr int kDropRounds = 8;     // in which a ball gives points up for a new one
constexpr int kRefitSteps = 14;
constexpr std::uint64_t kTabu = 8;           // moves for which a ball that gave something up is asked last, at most
constexpr std::uint64_t kLeastAttempts = 8;  // that the work suffices for: where refits are dear, one goal out of reach would take it all
constexpr std::uint64_t kTriangleWork =
    4;                           // a triangle searched for gaps costs as much as so many triangles or points of a refit, at least
constexpr double kRise = 0.05;   // by what share the first goal rises if it cannot be reached, at first
constexpr double kDepth = 0.5;   // share of the goal at which a ball sent to a sample holds it: at an edge no inscribed ball touches
constexpr double kClosed = 0.5;  // share of the gap tolerance to which holes are closed in the end
constexpr std::array<double, 2> kRooms{0, 0.5};  // rises of the stand-off that may take, as shares of the gap tolerance

// The balls, the samples, and who covers what at the present goal.
class StandOffSearch {
 public:
  StandOffSearch(const DistanceField& field, std::span<const Vector3d> points, std::vector<Ball> balls, std::uint64_t seed,
                 std::uint64_t& work)
      : field_(field),
        work_(work),
        samples_(points),
        balls_(std::move(balls)),
        state_(samples_.size()),
        near_(balls_.size()),
        near_to_(balls_.size(), -kInfinity),
        covered_(balls_.size()),
        private_(balls_.size()),
        tabu_(balls_.size()),
        random_(seed) {}

  const std::vector<Ball>& balls() const { return balls_; }
  void setBalls(std::span<const Ball> balls) {
    for (std::size_t b = 0; b < balls.size(); ++b) setBall(b, balls[b]);
  }
  // One more sample, covered or open like the others.
  void append(const Vector3d& p) {
    const auto s = static_cast<std::uint32_t>(samples_.size());
    samples_.append(p);
    state_.emplace_back();
    open_.grow();
    open_.insert(s);
    for (std::uint32_t b = 0; b < balls_.size(); ++b) {
      const double far = balls_[b].radius + std::max(goal_, near_to_[b]), d2 = (p - balls_[b].centre).squaredNorm();
      if (!(d2 <= far * far)) continue;
      const double gap = std::sqrt(d2) - balls_[b].radius;
      if (gap <= near_to_[b]) near_[b].push_back({s, gap});
      if (gap <= goal_) take(b, s);
    }
  }
  std::vector<std::uint32_t> takeMoved() { return std::exchange(moved_, {}); }

  // Largest gap of a sample. `guess`: a stand-off near it; it only saves time.
  double standOff(double guess) const {
    std::vector<double> least(samples_.size(), kInfinity);
    for (const Ball& b : balls_)
      samples_.within(b.centre, b.radius + guess,
                      [&](std::uint32_t s, double distance) { least[s] = std::min(least[s], distance - b.radius); });
    double most = 0;
    for (std::size_t s = 0; s < least.size(); ++s) {
      if (least[s] == kInfinity)
        for (const Ball& b : balls_) least[s] = std::min(least[s], (samples_[s] - b.centre).norm() - b.radius);
      most = std::max(most, least[s]);
    }
    return most;
  }

  // Moves are counted from here on.
  void setGoal(double goal) {
    goal_ = goal;
    for (Sample& sample : state_) sample.count = sample.owner = 0;
    std::fill(private_.begin(), private_.end(), 0);
    std::fill(tabu_.begin(), tabu_.end(), 0);
    move_ = 0;
    open_.reset(samples_.size());
    for (std::uint32_t s = 0; s < samples_.size(); ++s) open_.insert(s);
    for (std::uint32_t b = 0; b < balls_.size(); ++b) cover(b);
  }

  bool isReached() const { return open_.empty(); }
  // Moves balls until every sample is covered at the goal. False if that takes more than `moves`, or the work so far
  // more than
  // `most_work`.
  bool reach(int moves, std::uint64_t most_work, const Progress& progress) {
    for (int i = 0; !isReached(); ++i) {
      if (i == moves || work_ > most_work) return false;
      if (++move_ % 64 == 0) progress.check();
      place(open_.anyOf(random_()));
    }
    return true;
  }

 private:
  struct Sample {
    std::uint32_t count = 0;  // balls that cover it
    std::uint32_t owner = 0;  // their exclusive or: the ball itself where there is one
    double weight = 1;        // more for every time it was hard to cover
  };
  struct Near {
    std::uint32_t sample;
    double gap;
  };

  void setBall(std::size_t b, const Ball& to) {
    balls_[b] = to;
    near_to_[b] = -kInfinity;
  }
  void cover(std::uint32_t b) {
    if (!(near_to_[b] >= goal_)) {
      near_[b].clear();
      samples_.within(balls_[b].centre, balls_[b].radius + goal_, [&](std::uint32_t s, double distance) {
        near_[b].push_back({s, distance - balls_[b].radius});
      });
      near_to_[b] = goal_;
    }
    covered_[b].clear();
    for (const auto& [s, gap] : near_[b])
      if (gap <= goal_) take(b, s);
  }
  void take(std::uint32_t b, std::uint32_t s) {
    covered_[b].push_back(s);
    Sample& sample = state_[s];
    if (sample.count == 0) open_.erase(s), private_[b] += sample.weight;
    if (sample.count == 1) private_[sample.owner] -= sample.weight;
    ++sample.count;
    sample.owner ^= b;
  }
  void uncover(std::uint32_t b) {
    for (const std::uint32_t s : covered_[b]) {
      Sample& sample = state_[s];
      --sample.count;
      sample.owner ^= b;
      if (sample.count == 0) open_.insert(s), private_[b] -= sample.weight;
      if (sample.count == 1) private_[sample.owner] += sample.weight;
    }
  }

  // Has a ball take sample `s`: the one that has to give up least.
  void place(std::uint32_t s) {
    const Vector3d p = samples_[s];
    std::array<std::pair<double, std::uint32_t>, kAsked> nearest;  // least gap at p first
    std::size_t count = 0;
    for (std::uint32_t b = 0; b < balls_.size(); ++b) {
      const double far = balls_[b].radius + (count == kAsked ? nearest[kAsked - 1].first : kInfinity);
      const double d2 = (balls_[b].centre - p).squaredNorm();
      if (count == kAsked && !(d2 < far * far)) continue;
      std::size_t i = count < kAsked ? count++ : kAsked - 1;
      const double gap = std::sqrt(d2) - balls_[b].radius;
      for (; i > 0 && nearest[i - 1].first > gap; --i) nearest[i] = nearest[i - 1];
      nearest[i] = {gap, b};
    }
    double least_cost = kInfinity;
    std::uint32_t chosen = kNone;
    Ball to;
    for (std::size_t i = 0; i < 2 * count && least_cost > 0; ++i) {  // those that gave something up lately are asked last
      if (i == count && chosen != kNone) break;
      const std::uint32_t b = nearest[i % count].second;
      if ((tabu_[b] > move_) != (i >= count)) continue;
      Ball trial = balls_[b];
      const double cost = costToTake(b, s, least_cost, trial);
      if (cost < least_cost) least_cost = cost, chosen = b, to = trial;
    }
    if (least_cost > 0) {
      // Or the ball that is missed least, wherever it is, comes here.
      std::uint32_t idle = kNone;
      for (std::uint32_t b = 0; b < balls_.size(); ++b)
        if (tabu_[b] <= move_ && (idle == kNone || private_[b] < private_[idle])) idle = b;
      if (idle != kNone && private_[idle] < least_cost) {
        const Ball below = ballFor(p);
        if ((below.centre - p).norm() - below.radius <= goal_) least_cost = private_[idle], chosen = idle, to = below;
      }
    }
    if (least_cost > 0) {
      for (const std::uint32_t q : open_) ++state_[q].weight;
      if (chosen == kNone) return;  // its weight will make it dearer to lose
      tabu_[chosen] = move_ + 1 + random_() % kTabu;
    }
    uncover(chosen);
    setBall(chosen, to);
    cover(chosen);
    moved_.push_back(chosen);
  }

  // A ball that covers a point of the surface at the goal, if it is one: the largest straight below it that is no
  // farther from it than kDepth. Where the solid ends before, the one that touches as far beside it on its triangle; on
  // a sheet, the point.
  Ball ballFor(const Vector3d& p) const {
    const NearestPoint here = field_.nearest(p);
    const Ball below = shrinkingBall(field_, here.point, field_.pseudonormal(here), 0, kDepth * goal_);
    if (below.radius > 0) return below;
    const auto [a, b, c] = field_.corners(here.triangle);
    const Vector3d to_middle = (a + b + c) / 3 - p;
    const double beside = std::min(1.0, kDepth * goal_ / std::max(to_middle.norm(), std::numeric_limits<double>::min()));
    const Ball aside = shrinkingBall(field_, p + beside * to_middle, field_.normal(here.triangle));
    return aside.radius > 0 ? aside : Ball{here.point, 0};
  }

  // A refit goes straight, and so out of a thin bent solid. The largest ball that touches where that one is nearest
  // takes its place, unless it stands off more from patch_ and the goal. Its stand-off.
  double comeInside(Ball& trial, double stand_off) {
    const Ball inner = touchingBall(field_, trial.centre);
    if (!(inner.radius > 0)) return stand_off;
    double reach = 0;
    for (const Vector3d& p : patch_) reach = std::max(reach, (p - inner.centre).norm());
    if (reach - inner.radius > std::max(stand_off, goal_)) return stand_off;
    trial = inner;
    return reach - inner.radius;
  }

  // Weight of the samples that ball `b` alone covers and must give up to take sample `s`; `trial` is where it goes.
  // Infinite if it cannot, or once the cost is known to be `enough`.
  double costToTake(std::uint32_t b, std::uint32_t s, double enough, Ball& trial) {
    patch_.clear();
    patch_samples_.clear();
    for (const std::uint32_t q : covered_[b])
      if (state_[q].count == 1) patch_.push_back(samples_[q]), patch_samples_.push_back(q);
    patch_.push_back(samples_[s]);
    patch_samples_.push_back(s);
    double cost = 0;
    for (int round = 0;; ++round) {
      const double width = std::sqrt(goal_ * (2 * std::max(trial.radius, 0.0) + goal_));
      const Refit refit = refitBall(field_, patch_, trial.centre, trial.radius, 0.2 * width, kRefitSteps, goal_);
      trial = {refit.centre, refit.clearance};
      work_ += refit.work;
      const double stand_off = trial.radius > 0 ? refit.stand_off : comeInside(trial, refit.stand_off);
      if (stand_off <= goal_) return trial.radius > 0 || !(balls_[b].radius > 0) ? cost : kInfinity;  // none leaves the solid
      if (round == kDropRounds || patch_.size() == 1) return kInfinity;
      // Give up the farthest of the others, half as deep as they are out: the next refit brings more in.
      double most = 0;
      for (std::size_t k = 0; k + 1 < patch_.size(); ++k) most = std::max(most, (patch_[k] - trial.centre).norm());
      const double limit = std::min(trial.radius + 0.5 * (stand_off + goal_), most) * (1 - 1e-12);
      std::size_t kept = 0;
      for (std::size_t k = 0; k < patch_.size(); ++k) {
        if (k + 1 < patch_.size() && (patch_[k] - trial.centre).norm() >= limit) {
          cost += state_[patch_samples_[k]].weight;
          continue;
        }
        patch_[kept] = patch_[k];
        patch_samples_[kept++] = patch_samples_[k];
      }
      patch_.resize(kept);
      patch_samples_.resize(kept);
      if (cost >= enough) return kInfinity;
    }
  }

  const DistanceField& field_;
  std::uint64_t& work_;  // triangles and points looked at by refits
  SampleIndex samples_;
  std::vector<Ball> balls_;  // radius d(c)
  double goal_ = 0;
  std::vector<Sample> state_;
  std::vector<std::vector<Near>> near_;              // samples of a gap up to near_to_ of the ball, all of them
  std::vector<double> near_to_;                      // at least any goal since the ball moved; -infinity: unknown
  std::vector<std::vector<std::uint32_t>> covered_;  // samples that a ball covers
  std::vector<double> private_;                      // weight of the samples that a ball alone covers
  std::vector<std::uint64_t> tabu_;                  // of a ball: the move until which it is asked last
  std::uint64_t move_ = 0;                           // number of the last, at this goal
  UncoveredSet open_;                                // samples that no ball covers
  std::vector<std::uint32_t> moved_;
  std::vector<Vector3d> patch_;
  std::vector<std::uint32_t> patch_samples_;
  std::mt19937_64 random_;
};

}  // namespace

double lowerStandOff(const TriangleMesh& mesh, const DistanceField& field, std::vector<Vector3d>& points, std::vector<Ball>& inscribed,
                     const StandOffSettings& settings, Progress& progress) {
  std::mt19937_64 random(settings.seed);
  std::uint64_t work = 0;
  GapSampler sampler(mesh, field, inscribed.size(), settings.gap_spacing);
  StandOffSearch search(field, points, inscribed, random(), work);

  // Covers at the goal `h` what the mesh has between the samples too, but for holes as deep as a share of it, by
  // sampling what was missed. False if it cannot.
  const auto settle = [&](double h, double tolerance, std::uint64_t most_work) {
    std::vector<Ball> was;
    search.takeMoved();
    for (;;) {
      const std::vector<std::uint32_t> moved = search.takeMoved();
      const std::vector<Vector3d> missed = sampler.find(search.balls(), h, tolerance, was, moved, progress);
      work += kTriangleWork * sampler.lookedAt();
      if (missed.empty()) return true;
      was = search.balls();
      points.insert(points.end(), missed.begin(), missed.end());
      for (const Vector3d& p : missed) search.append(p);
      if (search.isReached()) return true;  // what is missed still is rounding
      if (!search.reach(settings.moves, most_work, progress)) return false;
    }
  };

  // What a search on samples alone believes to be covered has holes between them: up, with the balls as they have moved
  // by then, and faster every time. From too high the way down is short; work spent in vain at the first goals would be
  // missed there.
  double h = settings.start * search.standOff(0.01 * field.diagonal()), rise = kRise;
  const std::uint64_t attempt = settings.work / kLeastAttempts + kTriangleWork * sampler.triangles();
  for (search.setGoal(h); !settle(h, settings.gap_tolerance, work + attempt); search.setGoal(h)) h *= 1 + rise, rise *= 1.5;
  inscribed = search.balls();
  const std::uint64_t all_work = std::max(settings.work, work + settings.work / 2);
  double step = settings.step;
  int failures = 0;
  while (failures < settings.failures && work < all_work && h > settings.enough) {
    const double goal = h * (1 - step);
    const std::uint64_t most_work = std::min(all_work, work + attempt);
    search.setGoal(goal);
    if (search.reach(settings.moves, most_work, progress) && settle(goal, settings.gap_tolerance, most_work)) {
      h = goal;
      inscribed = search.balls();
      step = std::min(step * 1.3, 2 * settings.step);
    } else {
      ++failures;
      step *= 0.5;  // from where the balls are now: most of them have come nearer to the next goal
    }
  }
  if (!settings.closes) return h;
  // What is left of a hole, certification closes by growth beyond h. Moves close half of it for less than that.
  search.setBalls(inscribed);
  for (const double room : kRooms) {
    const double goal = h * (1 + room * settings.gap_tolerance);
    const std::uint64_t most_work = work + attempt;
    search.setGoal(goal);
    if (!search.reach(settings.moves, most_work, progress) || !settle(goal, kClosed * settings.gap_tolerance, most_work)) continue;
    inscribed = search.balls();
    return goal;
  }
  return h;
}

}  // namespace spheretree::builder
