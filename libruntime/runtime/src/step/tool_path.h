// SPDX-License-Identifier: Apache-2.0
// The way of the tool in one constrained step: the pose that it has reached, the pairs that it can touch from there
// with their rows, and what limits the next piece.
#pragma once

#include "piece/best_pose.h"
#include "piece/margin_policy.h"
#include "piece/piece_limits.h"
#include "step/step_parts.h"

namespace spheretree::runtime {

/// The pose after this share of a step.
Configuration after(double share, const Displacement& step, const Configuration& from);

class ToolPath {
 public:
  ToolPath(StepParts& parts, const Configuration& haptic);

  StepParts& parts;
  const Configuration& haptic;
  const Configuration start;  // pose of the tool at the beginning of the step
  PieceLimits limits;
  MarginPolicy margin;

  const Configuration& now() const { return now_; }  // at the end of the last piece
  const PairSet& pairs() const { return pairs_; }    // all pairs within the margin of the pose of the search
  const RowSet& rows() const { return rows_; }       // rows of the pairs at now()
  double depth() const { return depth_; }            // penetration of the guaranteed surface [mm]
  double feltDepth() const { return felt_depth_; }   // penetration of the smooth patches [mm]
  const BestPose& best() const { return best_; }
  bool wasInside() const { return was_inside_; }        // of an object, in some piece
  bool isFree() const { return pairs_.pairs.empty(); }  // nothing is within the margin
  /// Whether the pairs are all that the tool can touch, and there are some.
  bool knowsContacts() const { return !isFree() && !margin.needsSearch() && !pairs_.coarse; }
  Displacement way() const;  // from now() to the haptic pose
  Vector6 scaledWay() const { return parts.scaledVector(way()); }

  /// Whether there is work left for another piece; if not, says so in the faults of the step.
  bool mayGoOn() const;
  /// Finds pairs and makes rows for the next pieces. Returns false if the list is full even for the smallest margin, or
  /// the work ran out: then the step ends here.
  bool search();
  /// The QP with the step `want` as its target; the answer is in the memory. Returns the distance by which all rows
  /// were relaxed.
  double solve(const Vector6& want);
  /// The step by which the rows push the tool while the bodies move by this share of their way.
  Displacement pushed(double share);
  /// Changes the rows for such a piece: the rows of an object move with it, and no pair may be deeper at the end of the
  /// piece than it is now.
  void carryRows(double share);
  /// The QP with the haptic pose as its target, after carryRows().
  double solveCarried(const Vector6& want) { return parts.solve(rows_, want); }

  /// makeRows() has to follow, unless the tool is free.
  void moveTo(const Configuration& pose) { now_ = pose; }
  void makeRows();
  /// Leaves out the pairs beyond the margin.
  void dropFar() { parts.keepNear(margin.value(), pairs_, rows_); }
  void dropAll() { pairs_ = {}; }
  /// The step answers with now() if it is free, or less deep than the best pose so far.
  void record();
  /// Moves to the pose that is nearest to the haptic pose of all that were recorded and that no row forbids. A tool in
  /// a hollow that is narrower than itself may find no pose at which its rows hold it, since with each pose others
  /// count; so it rests where it gets farthest.
  void returnToNearest();
  /// The step answers with now(), since bodies have moved and the best pose so far may be free no longer.
  void answerNow() {
    best_.set(now_, depth_);
    nearest_left_ = std::numeric_limits<double>::infinity();
  }

 private:
  ToolPath(StepParts& parts, const Configuration& haptic, const Displacement& hand_motion, const Displacement& to_hand);
  void addFelt();
  void carryRows(const PairSet& set, std::uint32_t first, double share);
  void moveCoarsely();

  Configuration now_;
  PairSet pairs_;
  RowSet rows_;
  double depth_ = 0, felt_depth_ = 0;
  BestPose best_;
  Configuration nearest_;
  double nearest_left_ = std::numeric_limits<double>::infinity();  // distance of nearest_ from the haptic pose [mm, scaled]
  bool was_inside_ = false;
};

}  // namespace spheretree::runtime
