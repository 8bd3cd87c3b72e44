// SPDX-License-Identifier: Apache-2.0
// How far a search for pairs looks, and when the next one is due. The list holds all pairs within a margin of the pose
// of the search: it is complete as long as tool and bodies have approached each other by no more than that. A large
// margin saves searches, a small one saves rows.
// Units: mm. Steps: docs/algorithms/runtime/constrained_step.md
#pragma once

#include <limits>

namespace spheretree::runtime {

inline constexpr double kMinMargin = 0.01;  // [mm]
inline constexpr double kContactMargin =
    1;  // largest margin if something is near: beyond it, searching again is cheaper than the rows of far pairs [mm]
inline constexpr double kFeltReach = 0.2;  // smooth patches farther away than this get their rows in later pieces [mm]
inline constexpr double kCarriedMargin =
    2;  // times the way of the bodies in a piece: they may push the tool by that way, and approach it by that way themselves
inline constexpr double kPiecesAhead = 8;  // number of pieces for which the pairs in the list should suffice

/// The margin of one step of the tool.
class MarginPolicy {
 public:
  /// The margin of the first search. `to_hand`: way of the tool to the haptic pose; `hand_motion`: way of the hand
  /// since the last step; `is_touching`: contacts held the tool in the last step.
  MarginPolicy(double to_hand, double hand_motion, bool is_touching);

  double value() const { return margin_; }
  double left() const { return margin_ - used_; }
  bool needsSearch() const { return needs_search_; }

  /// Tool and bodies have approached each other by at most `way`.
  void use(double way) { used_ += way; }
  /// A search with this margin was made at the present pose.
  void searched();
  /// A search found something: a smaller margin has fewer pairs. Returns false if the margin is small enough. After a
  /// full list, no margin of this step is larger than the one that is set now.
  bool shorten(bool is_list_full);

  /// The share of the bodies' way `way` for which the margin suffices.
  double shareOfBodies(double way) const;
  /// Returns whether a search is due before the bodies move by `way`. The margin is then what they need, in addition to
  /// `own` for the tool.
  bool widenForBodies(double own, double way);

  /// In free space the margin ended a way of the tool of which `rest` is left: a search is due.
  void growFree(double rest);
  /// At contacts the margin ended a way of this length after `share` of it. A search is due if the margin is too small
  /// for the rest.
  void growAlong(double share, double length);
  /// Pieces shrink, so fewer pairs can touch within the next kPiecesAhead of them. Returns whether the margin is now
  /// what those need, from the present pose; then pairs beyond it are superfluous.
  bool narrow(double piece);

  /// Smooth patches farther away than this are left to later pieces.
  double feltReach() const { return felt_reach_; }
  /// The tool is expected to move by `way` before the next rows of smooth patches are made.
  void feelWithin(double way);

 private:
  double margin_, limit_ = std::numeric_limits<double>::infinity();
  double used_ = 0;  // part of the margin
  double felt_reach_ = kFeltReach;
  bool needs_search_ = true;  // the pairs are not those within the margin of the present pose
};

}  // namespace spheretree::runtime
