// SPDX-License-Identifier: Apache-2.0
// Extrapolates the pieces of a step along curved contacts. The pieces are a fixed-point iteration: the plain step at a
// pose is the solution of its QP, and the tool has arrived where that is zero. The last two pieces give an estimate of
// how the plain step changes along the way (secant method).
// Paper: D. G. Anderson. Iterative procedures for nonlinear integral equations. J. ACM 12(4), 1965. This is Anderson
//        mixing with a memory of one step, Anderson(1), except that oscillating steps are only shortened.
// Units: mm, scaled as in qp6.h.
#pragma once

#include "contact/qp6.h"

namespace spheretree::runtime {

class SecantStep {
 public:
  /// Stores a piece: its plain step, and the way that the tool went.
  void note(const Vector6& plain, const Vector6& way);
  void forget() { has_last_ = false; }

  /// Whether the plain step is not clearly shorter than the last way. False if there is no last piece.
  bool isStagnant(const Vector6& plain) const { return has_last_ && plain.norm() > 0.7 * last_way_.norm(); }

  /// In a hollow the plain steps oscillate: the rows are tangents, and the deeper the haptic tool is below them, the
  /// farther each step overshoots. Returns the share of the plain step that ends at the minimum; 1 if it does not
  /// overshoot.
  double damping(const Vector6& plain) const;

  /// Along a curved contact the plain steps shrink (or grow) by about the same factor each time: the rows are tangents,
  /// and convergence is the slower, the deeper the haptic tool is below a convex surface. `further`: from the end of
  /// the plain step to the sum of the series. Returns false if there is no last piece, or a corner in between.
  bool extrapolate(const Vector6& plain, Vector6& further) const;

 private:
  Vector6 last_plain_, last_way_;
  bool has_last_ = false;
};

// Inline, since the shared library has to be small: each is called once.

inline void SecantStep::note(const Vector6& plain, const Vector6& way) {
  last_plain_ = plain;
  last_way_ = way;
  has_last_ = true;
}

inline double SecantStep::damping(const Vector6& plain) const {
  if (!has_last_ || !(plain.dot(last_way_) < 0)) return 1;
  const double overshoot = (last_plain_ - plain).dot(last_way_), square = last_way_.squaredNorm();
  return overshoot > square ? square / overshoot : 1;
}

inline bool SecantStep::extrapolate(const Vector6& plain, Vector6& further) const {
  if (!has_last_) return false;
  const Vector6 change = plain - last_plain_;
  const double shrink = -change.dot(last_way_), square = last_way_.squaredNorm();
  if (!(plain.dot(last_plain_) > 0.1 * plain.norm() * last_plain_.norm())) return false;  // there is a corner in between
  further = 3 * plain;                                                                    // off a ridge, where steps grow
  if (shrink > 0.05 * square) further = -(plain.dot(change) / change.squaredNorm()) * (last_way_ + change);
  return true;
}

}  // namespace spheretree::runtime
