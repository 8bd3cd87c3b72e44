// SPDX-License-Identifier: Apache-2.0
// The pieces of a constrained step in which the tool moves towards the haptic pose, while the bodies rest.
#pragma once

#include "piece/rest_rule.h"
#include "step/tool_path.h"

namespace spheretree::runtime {

/// Each piece is safe as a whole. All pairs that can touch within it are in the list, since no point of the tool moves
/// farther than the margin. A row holds along the piece, because it holds at its start (gap >= 0) and at its end (a . y
/// >= b). The true gap is the row's value plus a convex function of the translation, minus at most |r| angle^2 / 2 for
/// the rotation. Hence no pair is ever deeper than that.
class Approach {
 public:
  explicit Approach(ToolPath& path) : path_(path), parts_(path.parts), memory_(path.parts.memory) {}
  /// Makes the next piece, with the pairs of the last search.
  Piece next() { return path_.isFree() ? freePiece() : contactPiece(); }

 private:
  Piece freePiece();
  Piece contactPiece();
  void plan(Piece& piece);
  void limit(const Vector6& step, Piece& piece) const;
  void prepare(const Piece& piece);
  void go(Piece& piece);
  void judge(Piece& piece);
  bool isHeld(const Vector6& want) const;
  Vector6 unbalanced(Vector6 sum, double largest_gap) const;

  ToolPath& path_;
  StepParts& parts_;
  StepMemory& memory_;
  SecantStep secant_;
  RestRule rest_;
};

}  // namespace spheretree::runtime
