// SPDX-License-Identifier: Apache-2.0
#include "piece/piece_limits.h"

#include <gtest/gtest.h>

namespace spheretree::runtime {
namespace {

constexpr double kTurnLength = 10, kReach = 60;  // [mm]

/// Limits of a step whose stretch is `before` at its beginning, for a hand that rests.
PieceLimits limitsFor(const Vector6& before, double min_contact = 2) {
  Coupling pull;
  pull.rotation = kTurnLength * kTurnLength;
  return {min_contact, kReach, ForceRateLimit(pull, kTurnLength, before, Vector6::Zero(), before)};
}

PieceLimits withoutForce(double min_contact = 2) {
  PieceLimits limits = limitsFor(Vector6::Zero(), min_contact);
  limits.force.lift();
  return limits;
}

/// A piece that moves by `x` mm and turns by `angle`.
Piece pieceOf(double x, double angle, Vector6& scaled) {
  Piece piece{Configuration{}};
  piece.step = {{x, 0, 0}, {0, angle, 0}};
  piece.length = x + kReach * angle;
  piece.turn = angle;
  scaled << piece.step.translation, kTurnLength * piece.step.rotation;
  piece.want = scaled;
  return piece;
}

TEST(PieceLimits, AStepWithinTheMarginIsMadeAsAWhole) {
  Vector6 step;
  Piece piece = pieceOf(0.5, 0, step);
  withoutForce().shorten(step, 0.5, piece);
  EXPECT_EQ(piece.share, 1);
  EXPECT_EQ(piece.end, PieceEnd::GoesOn);
}

TEST(PieceLimits, AStepEndsAtTheMargin) {
  Vector6 step;
  Piece piece = pieceOf(4, 0, step);
  withoutForce().shorten(step, 1, piece);
  EXPECT_EQ(piece.share, 0.25);
  EXPECT_EQ(piece.end, PieceEnd::AtMargin);
  Piece at_end = pieceOf(4, 0, step);
  withoutForce().shorten(step, 0, at_end);
  EXPECT_EQ(at_end.share, 0) << "nothing is left of the margin";
}

// A rotation by `angle` takes a point at the reach of the tool off its line by up to reach angle^2 / 2.
TEST(PieceLimits, ARotationStaysWithinThePathTolerance) {
  for (const double min_contact : {2.0, 0.04}) {
    const PieceLimits limits = withoutForce(min_contact);
    EXPECT_DOUBLE_EQ(limits.depth, std::min(kPathTolerance, 0.1 * min_contact));
    Vector6 step;
    Piece piece = pieceOf(0, 0.2, step);
    limits.shorten(step, 100, piece);
    EXPECT_LT(piece.share, 1);
    EXPECT_EQ(piece.end, PieceEnd::GoesOn);
    const double angle = 0.2 * piece.share;
    EXPECT_NEAR(kReach * angle * angle / 2, 0.8 * limits.depth, 1e-12);
  }
}

TEST(PieceLimits, TheForceEndsTheStepEvenIfTheMarginWouldSuffice) {
  Vector6 step;
  for (const double left : {100.0, 0.2}) {
    Piece piece = pieceOf(1, 0, step);
    limitsFor(piece.want).shorten(step, left, piece);
    EXPECT_NEAR(piece.share, kForceStep, 1e-12) << "at 1 N/mm";
    EXPECT_EQ(piece.end, PieceEnd::ForceLimit);
  }
  Piece piece = pieceOf(1, 0, step);
  limitsFor(piece.want).shorten(step, 0.02, piece);
  EXPECT_EQ(piece.end, PieceEnd::AtMargin) << "the margin comes first";
}

TEST(PieceEnd, TheStepEndsExceptWhereAnotherPieceFollows) {
  for (const PieceEnd end : {PieceEnd::GoesOn, PieceEnd::AtMargin}) EXPECT_FALSE(isLast(end) || hasArrived(end));
  for (const PieceEnd end : {PieceEnd::AtHand, PieceEnd::AtRest, PieceEnd::ForceLimit, PieceEnd::Stalled})
    EXPECT_TRUE(isLast(end) && hasArrived(end));
  EXPECT_TRUE(isLast(PieceEnd::Blocked));
  EXPECT_FALSE(hasArrived(PieceEnd::Blocked));
}

}  // namespace
}  // namespace spheretree::runtime
