// SPDX-License-Identifier: GPL-3.0-or-later
#include "cover/cover_state.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "medial/refit_ball.h"
#include "medial/shrinking_balls.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t kMaxTakers = 6;               // largest number of balls that are tried for a sample
constexpr int kDropRounds = 8;                      // rounds in which a ball gives up samples for a new one
constexpr std::uint64_t kTabu = 8;                  // largest number of moves for which a ball that gave up samples is tried last
constexpr std::array<double, 2> kDepths{0.5, 0.9};  // shares of the goal: gaps of a sample to the new balls that are tried for it; at
                                                    // an edge no inscribed ball touches the sample

}  // namespace

CoverState::CoverState(const DistanceField& field, std::span<const Vector3d> samples, std::vector<Ball> balls, std::uint64_t seed)
    : field_(field), samples_(samples), state_(samples_.size()), random_(seed) {
  setBalls(balls);
}

void CoverState::setBalls(std::span<const Ball> balls) {
  while (balls_.size() > balls.size()) {
    left_.push_back(cells_.back().seen);
    balls_.pop_back();
    cells_.pop_back();
  }
  for (std::size_t b = 0; b < balls_.size(); ++b) moveBall(b, balls[b]);
  for (std::size_t b = balls_.size(); b < balls.size(); ++b) {
    balls_.push_back(balls[b]);
    cells_.push_back({.seen = balls[b]});
  }
}

std::vector<Ball> CoverState::takeLeft() {
  std::vector<Ball> left = std::exchange(left_, {});
  for (std::size_t b = 0; b < balls_.size(); ++b) {
    if (cells_[b].has_moved) left.push_back(cells_[b].seen);
    cells_[b].has_moved = false;
    cells_[b].seen = balls_[b];
  }
  return left;
}

void CoverState::append(const Vector3d& p) {
  const auto s = static_cast<std::uint32_t>(samples_.size());
  samples_.append(p);
  state_.emplace_back();
  open_.grow();
  open_.insert(s);
  for (std::uint32_t b = 0; b < balls_.size(); ++b) {
    const double far = balls_[b].radius + std::max(goal_, cells_[b].near_to), d2 = (p - balls_[b].centre).squaredNorm();
    if (!(d2 <= far * far)) continue;
    const double gap = std::sqrt(d2) - balls_[b].radius;
    if (gap <= cells_[b].near_to) cells_[b].near.push_back({s, gap});
    if (gap <= goal_) take(b, s);
  }
}

double CoverState::standOff(double guess) const {
  std::vector<double> smallest(samples_.size(), kInfinity);
  for (const Ball& b : balls_)
    samples_.within(b.centre, b.radius + guess,
                    [&](std::uint32_t s, double distance) { smallest[s] = std::min(smallest[s], distance - b.radius); });
  double largest = 0;
  for (std::size_t s = 0; s < smallest.size(); ++s) {
    if (smallest[s] == kInfinity)
      for (const Ball& b : balls_) smallest[s] = std::min(smallest[s], (samples_[s] - b.centre).norm() - b.radius);
    largest = std::max(largest, smallest[s]);
  }
  return largest;
}

void CoverState::setGoal(double goal) {
  goal_ = goal;
  for (Sample& sample : state_) sample.count = sample.owner = 0;
  for (Cell& cell : cells_) cell.own = 0, cell.tabu = 0;
  move_ = 0;
  open_.reset(samples_.size());
  for (std::uint32_t s = 0; s < samples_.size(); ++s) open_.insert(s);
  for (std::uint32_t b = 0; b < balls_.size(); ++b) cover(b);
}

bool CoverState::coverAll(int max_moves, std::uint64_t max_work, const Progress& progress) {
  for (int i = 0; !isCovered(); ++i) {
    if (i == max_moves || work_ > max_work) return false;
    ++moves_;
    if (++move_ % 64 == 0) progress.check();
    place(open_.anyOf(random_()));
  }
  return true;
}

void CoverState::removeBall() {
  const auto last = static_cast<std::uint32_t>(balls_.size() - 1);
  const std::uint32_t b = std::min(smallestUsefulBall(), last);
  uncover(b);
  left_.push_back(cells_[b].seen);
  if (b != last) {  // the last ball takes over index b
    uncover(last);
    balls_[b] = balls_[last];
    cells_[b] = std::move(cells_[last]);
    cells_[b].own = 0;
  }
  balls_.pop_back();
  cells_.pop_back();
  if (b != last) cover(b);
}

void CoverState::addBall() {
  const auto b = static_cast<std::uint32_t>(balls_.size());
  std::uint32_t largest = 0;
  for (std::uint32_t k = 1; k < b; ++k)
    if (cells_[k].own > cells_[largest].own) largest = k;
  balls_.push_back(open_.empty() ? balls_[largest] : ballFor(samples_[open_.anyOf(random_())]));
  cells_.push_back({.seen = balls_[b]});
  cover(b);
}

void CoverState::moveBall(std::size_t b, const Ball& to) {
  balls_[b] = to;
  cells_[b].near_to = -kInfinity;
  cells_[b].has_moved = true;
}

void CoverState::cover(std::uint32_t b) {
  Cell& cell = cells_[b];
  if (!(cell.near_to >= goal_)) {
    cell.near.clear();
    samples_.within(balls_[b].centre, balls_[b].radius + goal_, [&](std::uint32_t s, double distance) {
      cell.near.push_back({s, distance - balls_[b].radius});
    });
    cell.near_to = goal_;
  }
  cell.covered.clear();
  for (const auto& [s, gap] : cell.near)
    if (gap <= goal_) take(b, s);
}

void CoverState::take(std::uint32_t b, std::uint32_t s) {
  cells_[b].covered.push_back(s);
  Sample& sample = state_[s];
  if (sample.count == 0) open_.erase(s), cells_[b].own += sample.weight;
  if (sample.count == 1) cells_[sample.owner].own -= sample.weight;
  ++sample.count;
  sample.owner ^= b;
}

void CoverState::uncover(std::uint32_t b) {
  for (const std::uint32_t s : cells_[b].covered) {
    Sample& sample = state_[s];
    --sample.count;
    sample.owner ^= b;
    if (sample.count == 0) open_.insert(s), cells_[b].own -= sample.weight;
    if (sample.count == 1) cells_[sample.owner].own += sample.weight;
  }
}

// Gives sample `s` to the ball with the smallest loss.
void CoverState::place(std::uint32_t s) {
  const Vector3d p = samples_[s];
  std::array<std::pair<double, std::uint32_t>, kMaxTakers> nearest;  // sorted by gap at p
  std::size_t count = 0;
  for (std::uint32_t b = 0; b < balls_.size(); ++b) {
    const double far = balls_[b].radius + (count == kMaxTakers ? nearest[kMaxTakers - 1].first : kInfinity);
    const double d2 = (balls_[b].centre - p).squaredNorm();
    if (count == kMaxTakers && !(d2 < far * far)) continue;
    std::size_t i = count < kMaxTakers ? count++ : kMaxTakers - 1;
    const double gap = std::sqrt(d2) - balls_[b].radius;
    for (; i > 0 && nearest[i - 1].first > gap; --i) nearest[i] = nearest[i - 1];
    nearest[i] = {gap, b};
  }
  double min_cost = kInfinity;
  std::uint32_t chosen = kNone;
  Ball to;
  for (std::size_t i = 0; i < 2 * count && min_cost > 0; ++i) {  // tabu balls are tried last
    if (i == count && chosen != kNone) break;
    const std::uint32_t b = nearest[i % count].second;
    if ((cells_[b].tabu > move_) != (i >= count)) continue;
    Ball trial = balls_[b];
    const double cost = costToTake(b, s, min_cost, trial);
    if (cost < min_cost) min_cost = cost, chosen = b, to = trial;
  }
  if (min_cost > 0) {
    // Alternatively, the ball with the smallest loss, wherever it is, moves here.
    const std::uint32_t min_usefulness = smallestUsefulBall();
    if (min_usefulness != kNone && cells_[min_usefulness].own < min_cost) {
      const Ball below = ballFor(p);
      if ((below.centre - p).norm() - below.radius <= goal_) min_cost = cells_[min_usefulness].own, chosen = min_usefulness, to = below;
    }
  }
  if (min_cost > 0) {
    for (const std::uint32_t q : open_) ++state_[q].weight;
    if (chosen == kNone) return;  // the raised weight makes the sample less likely to be given up again
    cells_[chosen].tabu = move_ + 1 + random_() % kTabu;
  }
  uncover(chosen);
  moveBall(chosen, to);
  cover(chosen);
}

// The ball with the smallest weight of samples that only it covers, except tabu balls; kNone if all are tabu.
std::uint32_t CoverState::smallestUsefulBall() const {
  std::uint32_t min_usefulness = kNone;
  for (std::uint32_t b = 0; b < balls_.size(); ++b)
    if (cells_[b].tabu <= move_ && (min_usefulness == kNone || cells_[b].own < cells_[min_usefulness].own)) min_usefulness = b;
  return min_usefulness;
}

// A ball that covers a point of the surface at the goal, if possible: of the largest balls straight below it with a gap
// of kDepths times the goal, the one that covers more weight of open samples. A shallow one fits an edge, a deep one
// the ring of a rod. Where the solid is too thin for both, the ball that touches the surface at the smaller distance
// beside the point, on its triangle; on a sheet, the point itself.
Ball CoverState::ballFor(const Vector3d& p) const {
  const NearestPoint here = field_.nearest(p);
  const Vector3d normal = field_.pseudonormal(here);
  Ball best;
  double best_weight = -1;
  for (const double depth : kDepths) {
    const Ball below = shrinkingBall(field_, here.point, normal, depth * goal_);
    if (!(below.radius > 0)) continue;
    const double weight = openWeight(below);
    if (weight > best_weight) best = below, best_weight = weight;
  }
  if (best.radius > 0) return best;
  const auto [a, b, c] = field_.corners(here.triangle);
  const Vector3d to_middle = (a + b + c) / 3 - p;
  const double beside = std::min(1.0, kDepths[0] * goal_ / std::max(to_middle.norm(), std::numeric_limits<double>::min()));
  const Ball aside = shrinkingBall(field_, p + beside * to_middle, field_.normal(here.triangle));
  return aside.radius > 0 ? aside : Ball{here.point, 0};
}

// Weight of the open samples that the ball would cover at the goal.
double CoverState::openWeight(const Ball& ball) const {
  double weight = 0;
  samples_.within(ball.centre, ball.radius + goal_,
                  [&](std::uint32_t s, double) { weight += state_[s].count == 0 ? state_[s].weight : 0; });
  return weight;
}

// A refit moves in a straight line and may leave a thin curved solid. The largest ball that touches the surface nearest
// to the new centre replaces it, unless its stand-off is larger than both `stand_off` and the goal. Returns the new
// stand-off.
double CoverState::comeInside(Ball& trial, double stand_off) const {
  const Ball inner = touchingBall(field_, trial.centre);
  if (!(inner.radius > 0)) return stand_off;
  double reach = 0;
  for (const Vector3d& p : patch_) reach = std::max(reach, (p - inner.centre).norm());
  if (reach - inner.radius > std::max(stand_off, goal_)) return stand_off;
  trial = inner;
  return reach - inner.radius;
}

// Weight of the samples that only ball `b` covers and must give up to take sample `s`; `trial` receives the new ball.
// Infinite if it cannot, or as soon as the cost is known to be at least `target`.
double CoverState::costToTake(std::uint32_t b, std::uint32_t s, double target, Ball& trial) {
  patch_.clear();
  patch_samples_.clear();
  for (const std::uint32_t q : cells_[b].covered)
    if (state_[q].count == 1) patch_.push_back(samples_[q]), patch_samples_.push_back(q);
  patch_.push_back(samples_[s]);
  patch_samples_.push_back(s);
  double cost = 0;
  for (int round = 0;; ++round) {
    const double width = std::sqrt(goal_ * (2 * std::max(trial.radius, 0.0) + goal_));
    const Refit refit = refitBall(field_, patch_, trial.centre, trial.radius, kFirstStepShare * width, kCoverRefitSteps, goal_);
    trial = {refit.centre, refit.clearance};
    work_ += refit.work;
    const double stand_off = trial.radius > 0 ? refit.stand_off : comeInside(trial, refit.stand_off);
    if (stand_off <= goal_) return trial.radius > 0 || !(balls_[b].radius > 0) ? cost : kInfinity;  // no ball may leave the solid
    if (round == kDropRounds || patch_.size() == 1) return kInfinity;
    // Gives up the farthest of the other samples, down to half of the excess: the next refit improves the rest.
    double largest = 0;
    for (std::size_t k = 0; k + 1 < patch_.size(); ++k) largest = std::max(largest, (patch_[k] - trial.centre).norm());
    const double limit = std::min(trial.radius + 0.5 * (stand_off + goal_), largest) * (1 - 1e-12);
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
    if (cost >= target) return kInfinity;
  }
}

}  // namespace spheretree::builder
