// SPDX-License-Identifier: Apache-2.0
// Mode constrained. Guarantees: docs/runtime.md
#include <algorithm>
#include <cmath>
#include <limits>

#include "state/moving_bodies.h"
#include "step/best_pose.h"
#include "step/force_rate_limit.h"
#include "step/inside.h"
#include "step/margin_policy.h"
#include "step/secant_step.h"
#include "step/step_parts.h"

namespace spheretree::runtime {
namespace {

constexpr double kPathTolerance = 0.01;  // largest depth of a leaf within a piece [mm]
constexpr double kConverged = 2e-5;      // the graphic tool rests if the next step would be shorter [mm, scaled]
constexpr double kRounding = 3e-4;       // steps shorter than this that no longer shrink are float rounding of the gaps [mm, scaled]
constexpr int kMaxShorter = 5;           // attempts of a piece with moving bodies, each shorter
constexpr int kMaxLinearisations = 48;   // linearisations in one step
constexpr int kMaxHalvings = 5;
constexpr int kFeltHalvings = 2;    // halvings for smooth patches, which must not hold the tool back for long
constexpr int kPatience = 8;        // pieces after which progress is checked
constexpr double kProgress = 1e-3;  // an approach by less than this in kPatience pieces ends the step: the tool oscillates [mm, scaled]

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Displacement scaled(const Displacement& d, double factor) { return {factor * d.translation, factor * d.rotation}; }

/// The result of a piece.
enum class Piece { GoesOn, Arrived, Blocked };

class ConstrainedStep {
 public:
  ConstrainedStep(StepParts& parts, const Configuration& haptic)
      : ConstrainedStep(parts, haptic, displacementBetween(parts.memory.haptic, haptic),
                        displacementBetween(parts.memory.graphic, haptic)) {}
  void run();

 private:
  ConstrainedStep(StepParts& parts, const Configuration& haptic, const Displacement& hand_motion, const Displacement& to_hand);
  Piece carry();
  Piece carriedPiece(const BodyMotion& left);
  void carriedTo(double share, const Displacement& step, const Configuration& to);
  bool findPairs();
  Piece freePiece();
  Piece contactPiece();
  double solve(const Vector6& want);
  double acceptedShare(const Displacement& step, double share, bool is_straight);
  Vector6 unbalanced(Vector6 sum, double largest_gap) const;
  bool isSettled(const Vector6& want) const;
  bool hasStalled();
  void pushOut();
  bool isPressedIn() const;
  void takeBack();
  void noteContacts();
  void makeRows();
  void addFelt();
  void record() { best_.record(now_, depth_); }
  void coarseMove(PairSet pairs);

  StepParts& parts_;
  const CompiledScene& scene_;
  StepMemory& memory_;
  StepResult& result_;
  const Configuration& haptic_;
  const double path_tolerance_;  // largest depth of a leaf within a piece [mm]
  const double largest_turn_;    // largest rotation in a piece, which limits the depth [rad]
  ForceRateLimit force_limit_;
  MarginPolicy margin_;
  SecantStep secant_;

  const Configuration start_;  // pose of the tool at the beginning of the step
  Configuration now_;          // at the end of the last piece
  BestPose best_;
  double depth_ = 0;       // penetration of the guaranteed surface [mm]
  double felt_depth_ = 0;  // penetration of the smooth patches [mm]
  PairSet pairs_;          // all pairs within the margin of the pose of the search
  RowSet rows_;            // rows of the pairs at `now_`
  int pieces_ = 0;
  double nearest_ = kInfinity;  // distance to the haptic pose at the last check for progress [mm, scaled]
  Vector6 last_unbalanced_;     // after the step of the QP
  bool may_settle_ = false;     // the last piece was the whole step of a QP with the haptic pose as target
  bool was_inside_ = false;
  bool is_at_rest_ = false;  // the last QP had the haptic pose as target at `now_`, and its solution was to stay
};

ConstrainedStep::ConstrainedStep(StepParts& parts, const Configuration& haptic, const Displacement& hand_motion,
                                 const Displacement& to_hand)
    : parts_(parts),
      scene_(parts.scene),
      memory_(parts.memory),
      result_(parts.result),
      haptic_(haptic),
      path_tolerance_(std::min(kPathTolerance, 0.1 * scene_.min_contact)),
      largest_turn_(std::sqrt(1.6 * path_tolerance_ / std::max(scene_.tool.reach, 1e-6))),
      force_limit_(scene_.pull, scene_.angle_length, parts_.scaledVector(displacementBetween(memory_.graphic, memory_.haptic)),
                   parts_.scaledVector(hand_motion), parts_.scaledVector(to_hand)),
      margin_(parts_.reach(to_hand), parts_.reach(hand_motion), memory_.active_count > 0),
      start_(memory_.graphic),
      now_(memory_.graphic) {
  if (memory_.is_behind) force_limit_.lift();  // a tool that did not arrive because the work ran out may catch up
  // Along surfaces that already hold it, the tool moves about as far as the hand.
  if (memory_.active_count > 0 && !memory_.is_behind && memory_.moving_count == 0) margin_.feelWithin(1.5 * parts_.reach(hand_motion));
}

// Each piece is safe as a whole. All pairs that can touch within it are in the list, since no point of the tool moves
// farther than the margin. A row holds along the piece, because it holds at its start (gap >= 0) and at its end (a . y
// >= b). The true gap is the row's value plus a convex function of the translation, minus at most |r| angle^2 / 2 for
// the rotation. Hence no pair is ever deeper than that.
void ConstrainedStep::run() {
  const bool has_carried = memory_.moving_count > 0;
  if (memory_.tissue) memory_.give_before = memory_.give;
  Piece piece = has_carried ? carry() : Piece::GoesOn;
  while (piece == Piece::GoesOn) {
    if (result_.linearisations >= kMaxLinearisations || !parts_.workLeft()) {
      result_.faults |= kWorkLimit;
      break;
    }
    if (margin_.needsSearch() && !findPairs()) break;
    piece = pairs_.pairs.empty() ? freePiece() : contactPiece();
  }
  memory_.is_behind = piece != Piece::Arrived;
  pushOut();
  if (best_.isKnown()) {
    // Tissue is where the last piece left it.
    memory_.graphic = memory_.tissue ? now_ : best_.pose;
    result_.penetration = memory_.tissue ? depth_ : best_.depth;
  }
  if (memory_.tissue && !has_carried && isPressedIn()) takeBack();
  if (result_.penetration > kGapTolerance) result_.faults |= kPenetrating;
  noteContacts();
  // The way out of an object is not a motion that inertia continues.
  if (scene_.inertia.translation + scene_.inertia.rotation > 0)
    memory_.motion = was_inside_ ? Displacement() : displacementBetween(start_, memory_.graphic);
}

// Whether tissue has moved into the tool, which had not the time to give way; or may have done so, as there was not the
// time to search.
bool ConstrainedStep::isPressedIn() const {
  if (!best_.isKnown()) return memory_.graphic.position == start_.position;
  return depth_ > std::max(path_tolerance_, memory_.depth);
}

// Tool and tissue stay where the last step left them. In the next step, tissue that approaches a state of its solver
// waits, so that the tool can move away first.
void ConstrainedStep::takeBack() {
  memory_.tissue->takeBack();
  memory_.give = memory_.give_before;
  memory_.graphic = start_;
  memory_.is_behind = true;
  result_.penetration = memory_.depth;
  pairs_ = {};
}

// Moves the bodies to their targets; before the last piece the tool only moves where they push it. In the frame of an
// object such a piece is as safe as one of run(): the row holds at its start and at its end. The row neglects terms of
// second order in the rotation of the body, and pieces are short enough for them to be small. The result is Blocked if
// the step ends here, before the bodies have arrived.
Piece ConstrainedStep::carry() {
  const double own_margin = margin_.value();
  Piece piece = Piece::GoesOn;
  while (memory_.moving_count > 0) {
    if (result_.linearisations >= kMaxLinearisations || !parts_.workLeft()) {
      result_.faults |= kWorkLimit;
      return Piece::Blocked;
    }
    const BodyMotion left = motionLeft(memory_);
    if (margin_.widenForBodies(own_margin, left.length) && !findPairs()) {
      advanceBodies(1, memory_);
      memory_.sides_known = false;
      return Piece::Blocked;
    }
    if (pairs_.pairs.empty()) {
      carriedTo(std::min(1.0, margin_.left() / left.length), {}, now_);
    } else if (piece = carriedPiece(left); piece == Piece::Blocked) {
      result_.faults |= kWorkLimit;
      return piece;
    }
  }
  // A ball that is squeezed in by half may leave a skin on the other side: its side is determined again.
  if (depth_ > 0.5 * scene_.min_contact) memory_.sides_known = false;
  return piece;
}

// If the bodies arrive in this piece, the tool goes on to the haptic pose at the same time: in the frame of an object
// its motion is the same as if it did so afterwards. If that does not fit in a piece, the tool waits.
Piece ConstrainedStep::carriedPiece(const BodyMotion& left) {
  const QpAnswer& answer = memory_.answer;
  double share = std::min(margin_.shareOfBodies(left.length), std::sqrt(0.2 * path_tolerance_ / std::max(left.length * left.turn, 1e-12)));
  if (depth_ > path_tolerance_) share = std::min(share, 0.25 * scene_.min_contact / left.length);
  if (share == 1 && depth_ <= path_tolerance_ && !parts_.rubsOrGives()) {
    parts_.carryRows(pairs_, share, now_.position, rows_);
    const Vector6 want = parts_.scaledVector(displacementBetween(now_, haptic_));
    const double back = parts_.solve(rows_, want);
    const Displacement step = parts_.displacement(answer.y);
    const double way = parts_.reach(step), largest = std::min(margin_.left(), margin_.feltReach()) - left.length;
    if (back == 0 && answer.status == QpStatus::Optimal && way <= largest && step.rotation.norm() <= largest_turn_ &&
        force_limit_.shareWithin(want, answer.y, 1) == 1) {
      parts_.keepActive(pairs_);
      is_at_rest_ = answer.active_count == 0;
      carriedTo(share, step, is_at_rest_ ? haptic_ : moved(now_, step));
      return is_at_rest_ ? Piece::Arrived : Piece::GoesOn;
    }
    makeRows();
  }
  for (int n = 0; n < kMaxShorter; ++n) {
    parts_.carryRows(pairs_, share, now_.position, rows_);
    const CarriedPiece carried{share};
    if (parts_.rubsOrGives())
      parts_.solveContact(pairs_, rows_, Vector6::Zero(), now_, &carried);
    else
      parts_.solve(rows_, Vector6::Zero());
    parts_.keepActive(pairs_);
    const Displacement step = parts_.displacement(answer.y);
    const double room = margin_.left() - share * left.length, way = parts_.reach(step), turn = step.rotation.norm();
    if (way <= room && turn <= largest_turn_) {
      carriedTo(share, step, moved(now_, step));
      return Piece::GoesOn;
    }
    share *= 0.5 * std::min({1.0, room / way, largest_turn_ / std::max(turn, 1e-12)});
    makeRows();
  }
  return Piece::Blocked;
}

// Advances the tool and the bodies to the end of a piece. The motion of bodies explains a change of the force, as the
// motion of the hand does.
void ConstrainedStep::carriedTo(double share, const Displacement& step, const Configuration& to) {
  margin_.use(share * motionLeft(memory_).length + parts_.reach(step));
  for (const PairRun& run : pairs_.runs) {
    const MovingBody& body = memory_.bodies[memory_.objects[run.object].body];
    if (body.moves) force_limit_.allow(parts_.scaledVector(motionAt(body, share, now_.position)));
  }
  now_ = to;
  if (scene_.has_soft && !pairs_.pairs.empty()) parts_.giveWay(1);
  advanceBodies(share, memory_);
  if (!pairs_.pairs.empty()) makeRows();
  best_.set(now_, depth_);
}

void ConstrainedStep::makeRows() {
  rows_ = parts_.rows(pairs_, now_);
  addFelt();
}

void ConstrainedStep::addFelt() {
  parts_.addFelt(pairs_, now_, std::min(margin_.value(), margin_.feltReach()), rows_);
  depth_ = std::max(0.0, -static_cast<double>(rows_.smallest_gap));
  felt_depth_ = std::max(0.0, -static_cast<double>(rows_.smallest_felt_gap));
}

// Finds pairs and makes rows for the next pieces. Returns false if the list is full even for the smallest margin: then
// the step ends here.
bool ConstrainedStep::findPairs() {
  for (;;) {
    pairs_ = parts_.search(now_, margin_.value(), PairsOf::ContactSurface);
    if (!pairs_.coarse) {
      rows_ = parts_.rows(pairs_, now_);
      parts_.keepNear(margin_.value(), pairs_, rows_);
    }
    if (pairs_.pairs.empty() || !parts_.workLeft() || !margin_.shorten(pairs_.coarse)) break;
  }
  if (pairs_.coarse) {
    result_.faults |= parts_.workLeft() ? kPairsFull : kWorkLimit;
    if (parts_.workLeft() && !best_.isKnown()) coarseMove(pairs_);
    return false;
  }
  addFelt();
  if (depth_ > kGapTolerance) {
    force_limit_.lift();
    was_inside_ = true;
  }
  margin_.searched();
  record();
  return true;
}

// Nothing is within the margin: moves straight towards the haptic pose, as far as the margin and the force rate limit
// allow.
Piece ConstrainedStep::freePiece() {
  memory_.active_count = 0;
  result_.active = 0;
  if (scene_.has_soft) parts_.letGo();
  const Displacement want = displacementBetween(now_, haptic_);
  const Vector6 way = parts_.scaledVector(want);
  const double length = parts_.reach(want), left = std::max(0.0, margin_.left());
  const double share = force_limit_.shareWithin(way, way, std::min(1.0, length > left ? left / length : 1.0));
  bool has_arrived = true;
  if (share == 1) {
    now_ = haptic_;
  } else {
    has_arrived = share * length < left * (1 - 1e-9);
    now_ = moved(now_, scaled(want, share));
    margin_.growFree(length);
  }
  record();
  return has_arrived ? Piece::Arrived : Piece::GoesOn;
}

double ConstrainedStep::solve(const Vector6& want) {
  parts_.rubs = depth_ <= path_tolerance_;
  return parts_.rubsOrGives() ? parts_.solveContact(pairs_, rows_, want, now_, nullptr) : parts_.solve(rows_, want);
}

// Moves towards the haptic pose as far as the rows allow.
Piece ConstrainedStep::contactPiece() {
  const QpAnswer& answer = memory_.answer;
  const Vector6 want = parts_.scaledVector(displacementBetween(now_, haptic_));
  if (isSettled(want)) {
    is_at_rest_ = true;
    return Piece::Arrived;
  }
  const double back = solve(want);
  const Vector6 plain = answer.y;
  if (plain.norm() < kConverged || (plain.norm() < kRounding && secant_.isStagnant(plain))) {
    parts_.keepActive(pairs_);
    if (memory_.tissue) parts_.giveWay(1);  // unloaded tissue returns
    is_at_rest_ = true;
    return Piece::Arrived;
  }
  const double damped = secant_.damping(plain);
  Vector6 further;
  const bool is_accelerated =
      damped == 1 && back == 0 && !scene_.has_soft && answer.active_count > 0 && secant_.extrapolate(plain, further);
  if (is_accelerated) solve(want + further);  // the rows are the same, so the step is as safe as the plain one
  const Displacement step = parts_.displacement(answer.y);
  // An extrapolated solution without active rows does not end at the haptic pose.
  const bool is_straight = !is_accelerated && answer.active_count == 0 && back == 0 && answer.status == QpStatus::Optimal;
  const double length = parts_.reach(step), turn = step.rotation.norm(), left = std::max(0.0, margin_.left());
  double largest = std::min(1.0, length > left ? left / length : 1.0);
  const bool is_short_of_margin = largest < 1;
  if (turn * largest > largest_turn_) largest = largest_turn_ / turn;
  double share = force_limit_.shareWithin(want, answer.y, largest);
  const bool is_held_back = share < largest;
  share = std::min(share, damped);
  parts_.keepActive(pairs_);
  last_unbalanced_ = unbalanced(want - plain, kInfinity);
  if (back == 0 && margin_.narrow(share * length)) parts_.keepNear(margin_.value(), pairs_, rows_);
  margin_.feelWithin(0.5 * kPiecesAhead * share * length);
  const Configuration from = now_;
  share = acceptedShare(step, share, is_straight);
  if (share == 0) return Piece::Blocked;
  may_settle_ = share == 1 && back == 0 && !is_accelerated;
  if (is_accelerated && parts_.scaledVector(displacementBetween(now_, haptic_)).norm() > want.norm() + kProgress) {
    now_ = from;  // where the contact bends, the sum of the series is unreliable: the next piece is a plain one
    makeRows();
    secant_.forget();
    return Piece::GoesOn;
  }
  secant_.note(plain, share * answer.y);
  margin_.use(share * length);
  record();
  if ((is_straight && share == 1) || is_held_back || hasStalled()) return Piece::Arrived;
  if (is_short_of_margin) margin_.growAlong(share, length);
  return Piece::GoesOn;
}

// What the forces of the active rows, without friction, leave of the pull towards the haptic pose, `sum`. A row that
// the tool has left by more than `largest_gap` exerts none.
[[gnu::noinline]] Vector6 ConstrainedStep::unbalanced(Vector6 sum, double largest_gap) const {
  for (std::size_t k = 0; k < memory_.answer.active_count; ++k) {
    const std::uint32_t row = memory_.answer.active[k];
    if (rows_.b[row] < -static_cast<float>(largest_gap)) continue;
    for (std::size_t i = 0; i < 6; ++i)
      sum[static_cast<Eigen::Index>(i)] += memory_.active_multiplier[k] * static_cast<double>(rows_.rows.a[i][row]);
  }
  return sum;
}

// Whether the forces of the last QP still hold the tool and no row is violated: then the next QP would have the same
// forces, and its solution would be to stay. What they left before the last piece is held by friction.
bool ConstrainedStep::isSettled(const Vector6& want) const {
  return may_settle_ && memory_.answer.active_count == memory_.active_count && std::max(depth_, felt_depth_) < kConverged &&
         (unbalanced(want, kConverged) - last_unbalanced_).norm() < kConverged;
}

// Moves by `share` of `step`, or by half of it and so on, until the end is not too deep. Returns 0 if the rows conflict
// and there is no way on.
double ConstrainedStep::acceptedShare(const Displacement& step, double share, bool is_straight) {
  const Configuration from = now_;
  const double deepest = std::max(path_tolerance_, depth_ + 1e-6), deepest_felt = std::max(path_tolerance_, felt_depth_ + 1e-6);
  for (int halving = 0; halving <= kMaxHalvings; ++halving, share /= 2) {
    now_ = is_straight && share == 1 ? haptic_ : moved(from, scaled(step, share));
    if (scene_.has_soft) parts_.giveWay(share);
    makeRows();
    if (depth_ <= deepest && (felt_depth_ <= deepest_felt || halving >= kFeltHalvings)) return share;
  }
  if (memory_.tissue) {
    now_ = from;
    parts_.giveWay(0);
    makeRows();
  }
  return 0;
}

// Whether the last kPatience pieces came no nearer to the haptic pose.
bool ConstrainedStep::hasStalled() {
  if (++pieces_ % kPatience != 0) return false;
  const double left_over = parts_.scaledVector(displacementBetween(now_, haptic_)).norm();
  const bool has_stalled = nearest_ - left_over < kProgress;
  nearest_ = left_over;
  return has_stalled;
}

// A piece with a rotation may end slightly inside. Moves straight out, if that works; otherwise the result is the last
// free pose.
void ConstrainedStep::pushOut() {
  for (int attempt = 0; attempt < 2; ++attempt) {
    const double deepest = std::max(depth_, felt_depth_);
    if (pairs_.pairs.empty() || margin_.needsSearch() || pairs_.coarse || deepest <= 0.5 * kGapTolerance || depth_ > path_tolerance_)
      return;
    is_at_rest_ = false;
    const CarriedPiece stays{0};
    if (parts_.rubsOrGives())
      parts_.solveContact(pairs_, rows_, Vector6::Zero(), now_, &stays);
    else
      parts_.solve(rows_, Vector6::Zero());
    parts_.keepActive(pairs_);
    const Displacement step = parts_.displacement(memory_.answer.y);
    margin_.use(parts_.reach(step));
    if (margin_.left() < 0) return;
    if (scene_.has_soft) parts_.giveWay(1);
    now_ = moved(now_, step);
    makeRows();
    record();
  }
}

// Stores the contacts that hold the graphic tool at its current pose. If the step ended for another reason than a QP
// whose solution was to stay, the QP is solved once more.
void ConstrainedStep::noteContacts() {
  memory_.contact_count = 0;
  if (pairs_.pairs.empty() || margin_.needsSearch() || pairs_.coarse) return;
  if (!is_at_rest_) {
    solve(parts_.scaledVector(displacementBetween(now_, haptic_)));
    parts_.keepActive(pairs_);
  }
  parts_.noteContacts(rows_, start_);
}

// The list is full even for the smallest margin. Inner nodes then replace whole branches, as the balls around their
// leaves: none may come closer than it is. This only steers and proves nothing; therefore the step is tiny, and is made
// only if a complete search for overlapping leaf pairs finds none.
void ConstrainedStep::coarseMove(PairSet pairs) {
  const Configuration from = memory_.graphic;
  parts_.findActive(pairs);
  RowSet set = parts_.rows(pairs, from);
  parts_.allowStaying(set);
  parts_.solve(set, parts_.scaledVector(displacementBetween(from, haptic_)));
  parts_.keepActive(pairs);
  const Displacement step = parts_.displacement(memory_.answer.y);
  const double largest = std::min({kMinMargin, path_tolerance_, 0.25 * scene_.min_contact}), length = parts_.reach(step),
               turn = step.rotation.norm();
  double share = 1;
  if (length > largest) share = largest / length;
  if (turn * share > largest_turn_) share = largest_turn_ / turn;
  const Configuration to = moved(from, scaled(step, share));
  pairs = parts_.search(to, 0, PairsOf::ContactSurface);
  if (pairs.coarse) return;
  const double depth = std::max(0.0, -static_cast<double>(parts_.rows(pairs, to).smallest_gap));
  if (depth > 0.5 * kGapTolerance) return;
  memory_.graphic = to;
  result_.penetration = depth;
}

}  // namespace

void constrainedStep(StepParts& parts, const Configuration& haptic) {
  settleSides(parts);
  ConstrainedStep(parts, haptic).run();
  leaveInsides(parts);
}

}  // namespace spheretree::runtime
