// SPDX-License-Identifier: Apache-2.0
// How far a piece may go: to the end of the margin, by a largest rotation, and until the force has changed enough.
// Reasons: docs/algorithms/runtime/constrained_step.md
#pragma once

#include <algorithm>
#include <cmath>

#include "piece/force_rate_limit.h"
#include "piece/piece.h"

namespace spheretree::runtime {

inline constexpr double kPathTolerance = 0.01;  // largest depth of a leaf within a piece [mm]

struct PieceLimits {
  /// `min_contact`: the smallest distance at which a ball of the tool is held; `reach`: the largest distance of a point
  /// of the tool from its reference point [mm].
  PieceLimits(double min_contact, double reach, const ForceRateLimit& of_force)
      : depth(std::min(kPathTolerance, 0.1 * min_contact)), turn(std::sqrt(1.6 * depth / std::max(reach, 1e-6))), force(of_force) {}

  const double depth;  // largest depth of a leaf within a piece [mm]
  const double turn;   // largest rotation in a piece, which limits the depth [rad]
  ForceRateLimit force;

  /// Computes the share of the step that the piece may make, and why it is not the whole. `step`: the same, scaled;
  /// `left`: what is left of the margin [mm].
  void shorten(const Vector6& step, double left, Piece& piece) const;
};

// Inline, since the shared library has to be small.

inline void PieceLimits::shorten(const Vector6& step, double left, Piece& piece) const {
  double largest = 1;
  if (piece.length > left) {
    largest = left / piece.length;
    piece.end = PieceEnd::AtMargin;
  }
  if (piece.turn * largest > turn) largest = turn / piece.turn;
  piece.share = force.shareWithin(piece.want, step, largest);
  if (piece.share < largest) piece.end = PieceEnd::ForceLimit;
}

}  // namespace spheretree::runtime
