// SPDX-License-Identifier: Apache-2.0
// When the pieces of a step end: the contacts hold the tool where it is, or it comes no nearer to the haptic pose.
// Units: mm, scaled as in qp6.h.
#pragma once

#include <limits>

#include "piece/secant_step.h"

namespace spheretree::runtime {

inline constexpr double kConverged = 2e-5;  // the graphic tool rests if the next step would be shorter [mm, scaled]
inline constexpr double kRounding = 3e-4;   // steps shorter than this that no longer shrink are float rounding of the gaps [mm, scaled]
inline constexpr int kPatience = 8;         // pieces after which progress is checked
inline constexpr double kProgress =
    1e-3;  // an approach by less than this in kPatience pieces ends the step: the tool oscillates [mm, scaled]

class RestRule {
 public:
  /// Whether the plain step of the next piece is too short to be made.
  static bool isNegligible(const Vector6& plain, const SecantStep& last) {
    const double length = plain.norm();
    return length < kConverged || (length < kRounding && last.isStagnant(plain));
  }

  /// After a QP: what its contact forces leave of the pull towards the haptic pose, which friction holds.
  void noteForces(const Vector6& unbalanced) { last_unbalanced_ = unbalanced; }
  /// After a piece: whether it was the whole plain step of a QP, so that its forces may hold the tool at its end.
  void notePiece(bool is_whole) { may_hold_ = is_whole; }
  bool mayHold() const { return may_hold_; }
  /// Whether the same forces hold the tool after the piece, where they leave `unbalanced`.
  bool holds(const Vector6& unbalanced) const { return (unbalanced - last_unbalanced_).norm() < kConverged; }

  /// Counts a piece. Returns whether progress has to be checked after it.
  bool isCheckDue() { return ++pieces_ % kPatience == 0; }
  /// Whether the tool, `left_over` away from the haptic pose, has come no nearer since the last check.
  bool hasStalled(double left_over) {
    const bool has_stalled = nearest_ - left_over < kProgress;
    nearest_ = left_over;
    return has_stalled;
  }

 private:
  Vector6 last_unbalanced_;
  bool may_hold_ = false;
  int pieces_ = 0;
  double nearest_ = std::numeric_limits<double>::infinity();  // distance to the haptic pose at the last check
};

}  // namespace spheretree::runtime
