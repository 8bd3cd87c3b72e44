// SPDX-License-Identifier: Apache-2.0
// A piece of the way of the tool in a constrained step. Units: mm, rad; vectors of the QP are scaled as in qp6.h.
#pragma once

#include "contact/qp6.h"
#include "spheretree/core/rigid.h"

namespace spheretree::runtime {

/// Why a piece ended, and with it perhaps the step.
enum class PieceEnd : std::uint8_t {
  GoesOn,      // as far as it could: the next piece goes on from there
  AtMargin,    // the same, and the pairs are known no farther
  AtHand,      // the tool is at the haptic pose
  AtRest,      // the contacts hold the tool where it is
  ForceLimit,  // the force must not change any more in this step
  Stalled,     // the tool oscillates, or the rows contradict each other
  Blocked,     // there was not the time to go on
};

inline bool isLast(PieceEnd end) { return end > PieceEnd::AtMargin; }
/// Whether the step has done what it could: the next one need not catch up.
inline bool hasArrived(PieceEnd end) { return isLast(end) && end != PieceEnd::Blocked; }

struct Piece {
  explicit Piece(const Configuration& at) : from(at) {}

  Configuration from;
  Vector6 want;                 // from there to the haptic pose
  Vector6 plain;                // what of this the rows allow: the solution of the QP
  Displacement step;            // of the tool: the same, or beyond it where the contact is curved
  double length = 0;            // bound of the way of a point of the tool in this step [mm]
  double turn = 0;              // its rotation where something is near [rad]
  double back = 0;              // the rows contradict each other by this [mm]
  bool is_straight = false;     // nothing holds the tool: the step ends at the haptic pose
  bool is_accelerated = false;  // the step is not the plain one
  double share = 0;             // the part of the step that the tool makes
  PieceEnd end = PieceEnd::GoesOn;
};

}  // namespace spheretree::runtime
