// SPDX-License-Identifier: GPL-3.0-or-later
#include "cover/cover_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::uint64_t kMinAttempts = 8;   // the work is divided into at least this many attempts, so that one unreachable goal cannot
                                            // use all of it where refits are expensive
constexpr std::uint64_t kTriangleWork = 4;  // cost of a triangle that is searched for gaps, in triangles or points of a refit
constexpr double kFirstGoal = 1.1;      // first goal, as a multiple of the stand-off on the samples: points between them lie farther out
constexpr double kRise = 0.05;          // share by which the first goal rises at first, if it cannot be reached
constexpr double kRiseGrowth = 1.5;     // factor by which this share grows each time
constexpr double kFirstReach = 0.01;    // share of the diagonal: first guess of the stand-off, which only saves time
constexpr std::uint64_t kLeftOver = 2;  // one over this of the work is left at least, when the first goal has been reached
constexpr double kStepGrowth = 1.3;     // factor on the step after a goal that was reached ...
constexpr double kLargestStep = 2;      // ... up to this multiple of the first step
constexpr double kRoughly = 0.3;        // the search on samples alone ends with a step below this share of the first one
constexpr double kClosed = 0.5;         // share of the gap tolerance to which close() closes gaps
constexpr double kRounded = 1 - 1e-12;  // factor on a wanted stand-off, so that rounded radii still keep it
constexpr std::array<double, 2> kGoalRises{0, 0.5};  // rises of the stand-off that close() tries, as shares of the gap tolerance

}  // namespace

CoverSearch::CoverSearch(const TriangleMesh& mesh, const DistanceField& field, SearchStart start, const SearchSettings& settings,
                         Progress& progress)
    : settings_(settings),
      points_(std::move(start.samples)),
      sampler_(mesh, field, std::max(start.balls.size(), start.count), settings.gap_spacing),
      state_(field, points_, std::move(start.balls), std::mt19937_64(start.seed)()),
      max_work_(settings.work / kMinAttempts) {
  // The samples alone show where balls belong, and cost a fraction of a search of the mesh; they get one attempt's
  // work. The stand-off of n balls falls about as 1/n; at that goal balls join where samples are open.
  const std::size_t given = state_.balls().size(), count = start.count > 0 ? start.count : given;
  const double goal = state_.standOff(kFirstReach * field.diagonal()) * static_cast<double>(given) / static_cast<double>(count);
  state_.setGoal(goal);
  setCount(count);
  reachFrom(goal, Extent::Samples, progress);
  lower(0, kRoughly * settings_.step, Extent::Samples, progress);
  state_.setBalls(best_);
  reachFrom(kFirstGoal * stand_off_, Extent::Mesh, progress);
  max_work_ = std::max(settings_.work, work() + settings_.work / kLeftOver);
}

Cover CoverSearch::cover() const {
  Cover cover{best_, stand_off_};
  for (Ball& b : cover.balls) b.radius += stand_off_;
  return cover;
}

void CoverSearch::lower(double target, Progress& progress) { lower(target, settings_.last_step, Extent::Mesh, progress); }

void CoverSearch::lower(double target, double last_step, Extent extent, Progress& progress) {
  for (double step = settings_.step; step >= last_step && work() < max_work_ && stand_off_ > target;) {
    const double goal = std::max(target, stand_off_ * (1 - step));
    state_.setGoal(goal);
    if (reach(goal, extent, std::min(max_work_, work() + attempt()), progress)) {
      keep(goal);
      step = std::min(step * kStepGrowth, kLargestStep * settings_.step);
    } else {
      step *= 0.5;  // continues from the current balls, most of which have come nearer to the next goal
    }
  }
}

bool CoverSearch::fit(double wanted, std::size_t max_balls, Progress& progress) {
  wanted *= kRounded;
  // A slightly corrected stand-off shares the moves of the last one; a different one has moves of its own.
  if (std::abs(wanted - fitted_to_) > settings_.step * wanted) removal_moves_ = 0;
  fitted_to_ = wanted;
  // A larger stand-off is kept already. Gaps that were found since then may need a few moves.
  if (stand_off_ <= wanted) change(best_.size(), wanted, progress);
  if (stand_off_ > wanted) addBalls(wanted, max_balls, progress);
  if (stand_off_ > wanted) {  // with all balls, in steps that become smaller
    max_work_ = work() + settings_.work;
    lower(wanted, progress);
    if (stand_off_ > wanted) {
      fitted_to_ = 0;
      close(progress);
      return false;
    }
  }
  removeBalls(progress);
  return true;
}

void CoverSearch::close(Progress& progress) {
  // Certification closes the remaining gaps by growth beyond the stand-off. Closing half of them by moves costs less.
  state_.setBalls(best_);
  const double h = stand_off_;
  for (const double rise : kGoalRises) {
    const double goal = h * (1 + rise * settings_.gap_tolerance);
    const std::uint64_t max_work = work() + attempt();
    state_.setGoal(goal);
    if (!coverAll(max_work, progress) || !settle(goal, kClosed * settings_.gap_tolerance, max_work, progress)) continue;
    keep(goal);
    return;
  }
}

bool CoverSearch::coverAll(std::uint64_t max_work, Progress& progress) {
  return state_.coverAll(settings_.moves, max_work - std::min(max_work, looked_at_), progress);
}

// Reaches the goal or, if that takes too long, a higher one. The goal rises with the balls in their moved positions,
// and faster each time: from a goal that is too high the way down is short, and work spent on unreachable first goals
// would be missing later.
void CoverSearch::reachFrom(double goal, Extent extent, Progress& progress) {
  double rise = kRise;
  for (state_.setGoal(goal); !reach(goal, extent, work() + attempt(), progress); state_.setGoal(goal))
    goal *= 1 + rise, rise *= kRiseGrowth;
  keep(goal);
}

bool CoverSearch::reach(double goal, Extent extent, std::uint64_t max_work, Progress& progress) {
  return coverAll(max_work, progress) && (extent == Extent::Samples || settle(goal, toleranceAt(goal), max_work, progress));
}

void CoverSearch::setCount(std::size_t balls) {
  while (state_.balls().size() > balls) state_.removeBall();
  while (state_.balls().size() < balls) state_.addBall();
}

// Also covers the mesh between the samples at the goal, except for gaps shallower than this share of it, by adding
// samples at uncovered points. Returns false if that fails.
bool CoverSearch::settle(double goal, double tolerance, std::uint64_t max_work, Progress& progress) {
  for (;;) {
    const std::vector<Ball> left = state_.takeLeft();
    const bool is_known = looked_for_ == std::pair(goal, tolerance);
    const std::vector<Vector3d> missed = sampler_.find(state_.balls(), goal, tolerance, is_known ? &left : nullptr, progress);
    looked_for_ = {goal, tolerance};
    looked_at_ += kTriangleWork * sampler_.lookedAt();
    if (missed.empty()) return true;
    points_.insert(points_.end(), missed.begin(), missed.end());
    for (const Vector3d& p : missed) state_.append(p);
    if (state_.isCovered()) return true;  // the remaining gaps are rounding errors
    if (!coverAll(max_work, progress)) return false;
  }
}

// Changes the number of balls of the best cover, at the goal; the result becomes the best cover if all samples and gaps
// can be covered.
bool CoverSearch::change(std::size_t balls, double goal, Progress& progress) {
  const std::uint64_t max_work = work() + attempt();
  state_.setBalls(best_);
  state_.setGoal(goal);
  setCount(balls);
  if (!reach(goal, Extent::Mesh, max_work, progress)) return false;
  keep(goal);
  return true;
}

// Adds balls until the stand-off is reached, in steps: for each the number that follows from stand-off ~ 1/n, or more
// if that does not suffice.
void CoverSearch::addBalls(double wanted, std::size_t max_balls, Progress& progress) {
  const auto limit = static_cast<double>(max_balls);
  for (double more = 1; stand_off_ > wanted && best_.size() < max_balls;) {
    const double goal = std::max(wanted, (1 - settings_.step) * stand_off_), now = static_cast<double>(best_.size()),
                 needed = std::min(std::max(std::ceil(more * now * stand_off_ / goal), now + 1), limit);
    if (change(static_cast<std::size_t>(needed), goal, progress))
      more = 1;
    else if (needed < limit)
      more *= 1 + kRise;
    else
      break;
  }
  if (stand_off_ > wanted && best_.size() < max_balls) change(max_balls, stand_off_, progress);
}

// Removes balls while the others can keep the stand-off: several at once, fewer after a failure. Removals before the
// first failure are cheap, and their number depends on the start of the search; therefore moves are counted only after
// that failure.
void CoverSearch::removeBalls(Progress& progress) {
  const auto all = static_cast<std::uint64_t>(settings_.removal_moves * static_cast<double>(best_.size()));
  const std::uint64_t max_moves = std::max(all - std::min(all, removal_moves_), all / kMinAttempts);
  const std::uint64_t max_work = work() + settings_.work;
  double share = settings_.step;
  std::uint64_t begun = state_.moves();
  for (int failures = 0; best_.size() > 1 && failures < settings_.failures && work() < max_work && state_.moves() - begun < max_moves;) {
    const auto removed = std::max<std::size_t>(1, static_cast<std::size_t>(share * static_cast<double>(best_.size())));
    if (change(best_.size() - removed, stand_off_, progress)) {
      failures = 0;
      if (share == settings_.step) begun = state_.moves();
    } else {
      share *= 0.5;
      failures += removed == 1;
    }
  }
  removal_moves_ += state_.moves() - begun;
}

std::uint64_t CoverSearch::attempt() const { return settings_.work / kMinAttempts + kTriangleWork * sampler_.triangles(); }

double CoverSearch::toleranceAt(double goal) const { return (goal <= fitted_to_ ? kClosed : 1) * settings_.gap_tolerance; }

void CoverSearch::keep(double goal) {
  best_ = state_.balls();
  stand_off_ = goal;
}

}  // namespace spheretree::builder
