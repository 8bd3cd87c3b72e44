// SPDX-License-Identifier: Apache-2.0
// Mode constrained. What it guarantees: docs/runtime.md
#include <algorithm>
#include <cmath>
#include <limits>

#include "step_parts.h"

namespace spheretree::runtime {
namespace {

constexpr double kPathTolerance = 0.01;  // deepest a leaf may dip in the middle of a step [mm]
constexpr double kLeastMargin = 0.01;    // [mm]
constexpr double kContactMargin = 1;     // most with something near: beyond, searching again is cheaper than the rows of far pairs [mm]
constexpr double kConverged = 2e-5;      // the graphic tool rests if the next step would be shorter [mm, scaled]
constexpr double kRounding = 3e-4;       // steps below this that no longer shrink are float rounding of the gaps [mm, scaled]
constexpr int kMostLinearisations = 48;  // of one step
constexpr int kMostHalvings = 5;
constexpr double kPiecesAhead = 8;  // that the pairs in the list are meant to last for
constexpr int kPatience = 8;        // pieces that bring the graphic tool
constexpr double kProgress = 1e-3;  // nearer by less than this are the last of a step: it goes to and fro [mm, scaled]

// A hand hardly feels a step of 0.1 N or 7 % of the force, 5 N mm or 13 % of the torque. These leave room for the last push out of a
// contact.
constexpr double kForceStep = 0.0995, kForceStepPart = 0.0695;  // [N]
constexpr double kTorqueStep = 4.95, kTorqueStepPart = 0.1295;  // [N mm]

/// Of the stretch of the springs in a step, at most: of all of it, of its translation, of its rotation [mm, scaled].
struct Change {
  double both, force, torque;
};
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr Change kAnyChange{kInfinity, kInfinity, kInfinity};

Displacement scaled(const Displacement& d, double factor) { return {factor * d.translation, factor * d.rotation}; }

class ConstrainedStep {
 public:
  explicit ConstrainedStep(StepParts& parts) : parts_(parts), scene_(parts.scene), workspace_(parts.workspace), result_(parts.result) {}
  void run(const Configuration& haptic);

 private:
  Change mostChange(const Configuration& haptic);
  double partWithin(const Configuration& now, const Configuration& haptic, const Vector6& way, const Change& change, double most) const;
  void accelerate(const RowSet& set, const Vector6& want, const Vector6& plain);
  void coarseMove(PairSet set, const Configuration& haptic, double path_tolerance, double largest_turn);

  StepParts& parts_;
  const Scene& scene_;
  Workspace& workspace_;
  StepResult& result_;
  Vector6 stretch_before_;         // of the springs, when the last step ended [mm, scaled]
  Vector6 last_plain_, last_way_;  // the piece before this one: what the QP wanted, and what was done
  bool has_last_ = false;
};

// Along a curved contact the plain steps shrink (or grow) by about the same factor each time: the rows are tangents, and the deeper the
// haptic tool is below a bump, the slower. The last two of them tell the factor (a secant, as in Anderson's mixing), and the sum of the
// series. The QP aims there instead; its rows are the same, so the step is as safe as the plain one.
void ConstrainedStep::accelerate(const RowSet& set, const Vector6& want, const Vector6& plain) {
  if (!has_last_) return;
  const Vector6 change = plain - last_plain_;
  const double shrink = -change.dot(last_way_), square = last_way_.squaredNorm();
  if (!(plain.dot(last_plain_) > 0.1 * plain.norm() * last_plain_.norm())) return;  // a corner lies between
  Vector6 further = 3 * plain;                                                      // off a ridge, where steps grow
  if (shrink > 0.05 * square) further = -(plain.dot(change) / change.squaredNorm()) * (last_way_ + change);
  parts_.solve(set, want + further);
}

// Where the nearest free pose is not continuous in the pose of the hand, the graphic tool slides to the new one over several steps: force
// and torque change by no more than they may where the free poses are a convex set, or than the hand moved and what can hardly be felt. The
// nearest point of a convex set is firmly non-expansive: a motion d of the hand changes the stretch by an s with |s - d/2| <= |d|/2. A tool
// that had not yet arrived for want of work is free to catch up.
Change ConstrainedStep::mostChange(const Configuration& haptic) {
  stretch_before_ = parts_.scaledVector(displacementBetween(workspace_.graphic, workspace_.haptic));
  if (workspace_.is_behind) return kAnyChange;
  const Vector6 hand = parts_.scaledVector(displacementBetween(workspace_.haptic, haptic)),
                at_rest = parts_.scaledVector(displacementBetween(workspace_.graphic, haptic)) - stretch_before_;
  const double both = std::max(hand.norm(), at_rest.norm()), translation = hand.head<3>().norm(),
               rotation = std::max(hand.tail<3>().norm(), at_rest.tail<3>().norm());
  const double force = translation + std::max(kForceStep / scene_.coupling.translation, kForceStepPart * stretch_before_.head<3>().norm()),
               torque = rotation + std::max(kTorqueStep * scene_.angle_length / scene_.coupling.rotation,
                                            kTorqueStepPart * stretch_before_.tail<3>().norm());
  return {std::max(both, force), std::max((both + translation) / 2, force), std::max((both + rotation) / 2, torque)};
}

// The largest part, up to `most`, of the piece `way` from `now` at whose end the stretch of the springs has changed by `change` or less.
double ConstrainedStep::partWithin(const Configuration& now, const Configuration& haptic, const Vector6& way, const Change& change,
                                   double most) const {
  const Vector6 so_far = parts_.scaledVector(displacementBetween(now, haptic)) - stretch_before_;
  const auto shorten = [&](const auto& changed, const auto& on_the_way, double limit) {
    const double square = on_the_way.squaredNorm();
    if (!(square > 0) || (changed - most * on_the_way).norm() <= limit) return;
    const double along = changed.dot(on_the_way), left = limit * limit - changed.squaredNorm();
    most = std::clamp((along + std::sqrt(std::max(0.0, along * along + square * left))) / square, 0.0, most);
  };
  shorten(so_far, way, change.both);
  shorten(so_far.head<3>(), way.head<3>(), change.force);
  shorten(so_far.tail<3>(), way.tail<3>(), change.torque);
  return most;
}

// Each piece of the way is safe as a whole. All pairs that can meet within it are in the list, since no point of the tool moves farther
// than the margin. A row holds along the piece from its start (gap >= 0) to its end (a . y >= b), and the true gap is the row's value
// plus a convex function of the translation, less at most |r| angle^2 / 2 for the turn. So no pair is ever deeper than that.
void ConstrainedStep::run(const Configuration& haptic) {
  const double path_tolerance = std::min(kPathTolerance, 0.1 * scene_.smallest_radius_sum);
  const double largest_turn = std::sqrt(1.6 * path_tolerance / std::max(scene_.tool.reach, 1e-6));
  Configuration now = workspace_.graphic;
  Configuration best = now;
  double best_depth = kInfinity;
  const double motion = parts_.reach(displacementBetween(workspace_.haptic, haptic));
  double margin_limit = kInfinity;
  double margin = std::max(kLeastMargin, std::min(parts_.reach(displacementBetween(now, haptic)), 1.5 * motion + 0.05));
  if (workspace_.active_count > 0) margin = std::min(margin, kContactMargin);
  PairSet pairs;
  RowSet set;
  double depth = 0, used = 0;
  bool stale = true;  // the pairs are not those of `margin` about `now`
  const auto record = [&] {
    if (depth < best_depth || depth <= 0.5 * kGapTolerance) {
      best = now;
      best_depth = depth;
    }
  };
  Change change = mostChange(haptic);
  bool settled = false;
  double nearest = kInfinity;
  int pieces = 0;
  while (!settled) {
    if (result_.linearisations >= kMostLinearisations || !parts_.workLeft()) {
      result_.faults |= kWorkLimit;
      break;
    }
    if (stale) {
      pairs = parts_.search(now, margin, false);
      while (margin > (pairs.coarse ? kLeastMargin : kContactMargin) && !pairs.pairs.empty() &&
             parts_.workLeft()) {  // a shorter way has fewer pairs
        margin = std::max(pairs.coarse ? kLeastMargin : kContactMargin, margin / 4);
        if (pairs.coarse) margin_limit = margin;
        pairs = parts_.search(now, margin, false);
      }
      if (pairs.coarse) {
        result_.faults |= parts_.workLeft() ? kPairsFull : kWorkLimit;
        if (parts_.workLeft() && best_depth == kInfinity) coarseMove(pairs, haptic, path_tolerance, largest_turn);
        break;
      }
      parts_.searchBridges(now, margin);
      if (margin > kContactMargin && parts_.anyBridges()) {
        margin = kContactMargin;
        parts_.searchBridges(now, margin);
      }
      parts_.findActive(pairs);
      set = parts_.allRows(pairs, now, margin);
      depth = std::max(0.0, -static_cast<double>(set.smallest_gap));
      if (depth > kGapTolerance) change = kAnyChange;
      used = 0;
      stale = false;
      record();
    }
    const Displacement want = displacementBetween(now, haptic);
    double length = parts_.reach(want);
    const double left = std::max(0.0, margin - used);
    if (parts_.isFree(pairs)) {
      workspace_.active_count = 0;
      result_.active = 0;
      const double part = partWithin(now, haptic, parts_.scaledVector(want), change, std::min(1.0, length > left ? left / length : 1.0));
      if (part == 1) {
        now = haptic;
        settled = true;
      } else {
        settled = part * length < left * (1 - 1e-9);
        now = moved(now, scaled(want, part));
        margin = std::min({4 * margin, length, margin_limit});
        stale = true;
      }
      record();
      continue;
    }
    const double back = parts_.solve(set, parts_.scaledVector(want));
    const Vector6 plain = workspace_.answer.y;
    if (plain.norm() < kConverged || (has_last_ && plain.norm() < kRounding && plain.norm() > 0.7 * last_way_.norm())) {
      parts_.keepActive(pairs);
      settled = true;
      break;
    }
    if (back == 0 && workspace_.answer.active_count > 0) accelerate(set, parts_.scaledVector(want), plain);
    const Displacement step = parts_.displacement(workspace_.answer.y);
    const bool straight = workspace_.answer.active_count == 0 && back == 0 && workspace_.answer.status == QpStatus::Optimal;
    length = parts_.reach(step);
    const double turn = step.rotation.norm();
    double part = std::min(1.0, length > left ? left / length : 1.0);
    const bool short_of_margin = part < 1;
    if (turn * part > largest_turn) part = largest_turn / turn;
    const double most = part;
    part = partWithin(now, haptic, workspace_.answer.y, change, most);
    const bool is_held_back = part < most;
    const Configuration from = now;
    const double depth_before = depth;
    parts_.keepActive(pairs);
    // Pieces shrink, and so does what the next few of them can meet.
    if (const double enough = kPiecesAhead * part * length + kLeastMargin; back == 0 && enough < 0.5 * left) {
      parts_.narrowTo(enough, set, now, pairs);
      margin = enough;
      used = 0;
    }
    bool accepted = false;
    for (int halving = 0; halving <= kMostHalvings && !accepted; ++halving) {
      now = straight && part == 1 ? haptic : moved(from, scaled(step, part));
      set = parts_.allRows(pairs, now, margin);
      depth = std::max(0.0, -static_cast<double>(set.smallest_gap));
      accepted = depth <= std::max(path_tolerance, depth_before + 1e-6);
      if (!accepted) part /= 2;
    }
    if (!accepted) break;  // rows that conflict: no way on from here in this step
    last_plain_ = plain;
    last_way_ = part * workspace_.answer.y;
    has_last_ = true;
    used += part * length;
    record();
    bool is_idle = false;
    if (++pieces % kPatience == 0) {
      const double left_over = parts_.scaledVector(displacementBetween(now, haptic)).norm();
      is_idle = nearest - left_over < kProgress;
      nearest = left_over;
    }
    if ((straight && part == 1) || is_held_back || is_idle) {
      settled = true;
    } else if (short_of_margin && margin - used < 0.5 * (1 - part) * length) {
      const double wish = std::max(margin, std::min({4 * margin, 1.1 * (1 - part) * length + kLeastMargin, kContactMargin}));
      margin = std::max(kLeastMargin, std::min(wish, margin_limit));
      stale = true;
    }
  }
  workspace_.is_behind = !settled;
  // A way that ends with a turn may end a little inside. Push straight out, or fall back to the last pose that was free.
  for (int attempt = 0;
       attempt < 2 && !parts_.isFree(pairs) && !stale && !pairs.coarse && depth > 0.5 * kGapTolerance && depth <= path_tolerance;
       ++attempt) {
    parts_.solve(set, Vector6::Zero());
    const Displacement step = parts_.displacement(workspace_.answer.y);
    used += parts_.reach(step);
    if (used > margin) break;
    now = moved(now, step);
    set = parts_.allRows(pairs, now, margin);
    depth = std::max(0.0, -static_cast<double>(set.smallest_gap));
    record();
  }
  if (best_depth < kInfinity) {
    workspace_.graphic = best;
    result_.penetration = best_depth;
  }
  if (result_.penetration > kGapTolerance) result_.faults |= kPenetrating;
}

// The list is full even for the shortest way. Whole branches stand in, as the balls about their leaves: none may come closer than it is.
// That steers, and proves nothing; so the step is tiny, and is taken only if a search for leaf pairs that overlap comes back in full and
// finds none.
void ConstrainedStep::coarseMove(PairSet pairs, const Configuration& haptic, double path_tolerance, double largest_turn) {
  const Configuration from = workspace_.graphic;
  parts_.findActive(pairs);
  const RowSet set = parts_.rows(pairs, from);
  parts_.allowStaying(set);
  parts_.solve(set, parts_.scaledVector(displacementBetween(from, haptic)));
  parts_.keepActive(pairs);
  const Displacement step = parts_.displacement(workspace_.answer.y);
  const double most = std::min({kLeastMargin, path_tolerance, 0.25 * scene_.smallest_radius_sum}), length = parts_.reach(step),
               turn = step.rotation.norm();
  double part = 1;
  if (length > most) part = most / length;
  if (turn * part > largest_turn) part = largest_turn / turn;
  const Configuration to = moved(from, scaled(step, part));
  pairs = parts_.search(to, 0, false);
  if (pairs.coarse) return;
  const double depth = std::max(0.0, -static_cast<double>(parts_.rows(pairs, to).smallest_gap));
  if (depth > 0.5 * kGapTolerance) return;
  workspace_.graphic = to;
  result_.penetration = depth;
}

}  // namespace

void constrainedStep(StepParts& parts, const Configuration& haptic) { ConstrainedStep(parts).run(haptic); }

}  // namespace spheretree::runtime
