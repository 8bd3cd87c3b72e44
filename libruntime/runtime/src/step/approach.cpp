// SPDX-License-Identifier: Apache-2.0
#include "step/approach.h"

#include <algorithm>
#include <limits>

namespace spheretree::runtime {
namespace {

constexpr int kMaxHalvings = 5;
constexpr int kFeltHalvings = 2;  // halvings for smooth patches, which must not hold the tool back for long

}  // namespace

// Nothing is within the margin: straight towards the haptic pose.
Piece Approach::freePiece() {
  memory_.active_count = 0;
  parts_.result.active = 0;
  if (parts_.scene.has_soft) parts_.letGo();
  Piece piece(path_.now());
  piece.step = path_.way();
  piece.want = parts_.scaledVector(piece.step);
  limit(piece.want, piece);
  if (piece.share == 1) {
    piece.end = PieceEnd::AtHand;
    path_.moveTo(path_.haptic);
  } else {
    // Both limits may be the same but for rounding.
    if (!(piece.share * piece.length < path_.margin.left() * (1 - 1e-9))) piece.end = PieceEnd::AtMargin;
    path_.moveTo(after(piece.share, piece.step, piece.from));
    path_.margin.growFree(piece.length);
  }
  path_.record();
  return piece;
}

// Towards the haptic pose as far as the rows allow.
Piece Approach::contactPiece() {
  Piece piece(path_.now());
  piece.want = path_.scaledWay();
  if (isHeld(piece.want)) {
    piece.end = PieceEnd::AtRest;
    return piece;
  }
  plan(piece);
  if (piece.end == PieceEnd::AtRest) return piece;
  prepare(piece);
  go(piece);
  if (piece.end != PieceEnd::Stalled) judge(piece);
  return piece;
}

// The step, and how much of it the tool may make.
void Approach::plan(Piece& piece) {
  const QpAnswer& answer = memory_.answer;
  piece.back = path_.solve(piece.want);
  piece.plain = answer.y;
  if (RestRule::isNegligible(piece.plain, secant_)) {
    parts_.keepActive(path_.pairs());
    if (memory_.tissue) parts_.giveWay(1);  // unloaded tissue returns
    piece.end = PieceEnd::AtRest;
    return;
  }
  const double damped = secant_.damping(piece.plain);
  Vector6 further;
  piece.is_accelerated =
      damped == 1 && piece.back == 0 && !parts_.scene.has_soft && answer.active_count > 0 && secant_.extrapolate(piece.plain, further);
  if (piece.is_accelerated) path_.solve(piece.want + further);  // the rows are the same, so the step is as safe as the plain one
  // An extrapolated solution without active rows does not end at the haptic pose.
  piece.is_straight = !piece.is_accelerated && answer.active_count == 0 && piece.back == 0 && answer.status == QpStatus::Optimal;
  piece.step = parts_.displacement(answer.y);
  piece.turn = piece.step.rotation.norm();
  limit(answer.y, piece);
  piece.share = std::min(piece.share, damped);
}

void Approach::limit(const Vector6& step, Piece& piece) const {
  piece.length = parts_.reach(piece.step);
  path_.limits.shorten(step, std::max(0.0, path_.margin.left()), piece);
}

// Keeps the contact forces, and the pairs that this piece and the next ones need.
void Approach::prepare(const Piece& piece) {
  parts_.keepActive(path_.pairs());
  rest_.noteForces(unbalanced(piece.want - piece.plain, std::numeric_limits<double>::infinity()));
  const double way = piece.share * piece.length;
  if (piece.back == 0 && path_.margin.narrow(way)) path_.dropFar();
  path_.margin.feelWithin(0.5 * kPiecesAhead * way);
}

// Moves by the share of the step, or by half of it and so on, until the end is not too deep.
void Approach::go(Piece& piece) {
  const double depth = path_.depth(), felt_depth = path_.feltDepth(), tolerance = path_.limits.depth,
               deepest = std::max(tolerance, depth + 1e-6), deepest_felt = std::max(tolerance, felt_depth + 1e-6);
  for (int halving = 0; halving <= kMaxHalvings; ++halving, piece.share /= 2) {
    path_.moveTo(piece.is_straight && piece.share == 1 ? path_.haptic : after(piece.share, piece.step, piece.from));
    if (parts_.scene.has_soft) parts_.giveWay(piece.share);
    path_.makeRows();
    if (path_.depth() <= deepest && (path_.feltDepth() <= deepest_felt || halving >= kFeltHalvings)) return;
  }
  piece.end = PieceEnd::Stalled;
  if (!memory_.tissue) return;
  path_.moveTo(piece.from);
  parts_.giveWay(0);
  path_.makeRows();
}

// What the piece achieved: whether it counts, and whether another one follows.
void Approach::judge(Piece& piece) {
  rest_.notePiece(piece.share == 1 && piece.back == 0 && !piece.is_accelerated);
  if (piece.is_accelerated && path_.scaledWay().norm() > piece.want.norm() + kProgress) {
    // Where the contact bends, the sum of the series is unreliable: the next piece is a plain one.
    path_.moveTo(piece.from);
    path_.makeRows();
    secant_.forget();
    piece.end = PieceEnd::GoesOn;
    return;
  }
  secant_.note(piece.plain, piece.share * memory_.answer.y);
  path_.margin.use(piece.share * piece.length);
  path_.record();
  if (piece.is_straight && piece.share == 1)
    piece.end = PieceEnd::AtHand;
  else if (piece.end != PieceEnd::ForceLimit && rest_.isCheckDue() && rest_.hasStalled(path_.scaledWay().norm()))
    piece.end = PieceEnd::Stalled;
  if (piece.end == PieceEnd::AtMargin) path_.margin.growAlong(piece.share, piece.length);
}

// Whether the forces of the last QP still hold the tool and no row is violated: then the next QP would have the same
// forces, and its solution would be to stay. What they left before the last piece is held by friction.
bool Approach::isHeld(const Vector6& want) const {
  return rest_.mayHold() && memory_.answer.active_count == memory_.active_count &&
         std::max(path_.depth(), path_.feltDepth()) < kConverged && rest_.holds(unbalanced(want, kConverged));
}

// What the forces of the active rows, without friction, leave of the pull towards the haptic pose, `sum`. A row that
// the tool has left by more than `largest_gap` exerts none.
[[gnu::noinline]] Vector6 Approach::unbalanced(Vector6 sum, double largest_gap) const {
  const RowSet& rows = path_.rows();
  for (std::size_t k = 0; k < memory_.answer.active_count; ++k) {
    const std::uint32_t row = memory_.answer.active[k];
    if (rows.b[row] < -static_cast<float>(largest_gap)) continue;
    for (std::size_t i = 0; i < 6; ++i)
      sum[static_cast<Eigen::Index>(i)] += memory_.active_multiplier[k] * static_cast<double>(rows.rows.a[i][row]);
  }
  return sum;
}

}  // namespace spheretree::runtime
