// SPDX-License-Identifier: Apache-2.0
// The parts that both modes of a step use (searches, rows and QPs, with their counts and times), and the modes
// themselves.
#pragma once

#include "contact/qp6.h"
#include "rows/rows.h"
#include "search/find_pairs.h"
#include "state/step_memory.h"

namespace spheretree::runtime {

/// A piece in which bodies move by this share of their way (0: do not move), while the tool moves only if it is pushed.
/// Contact forces, and therefore friction, are those of before the piece.
struct CarriedPiece {
  double share = 0;
};

class StepParts {
 public:
  StepParts(StepMemory& in_memory, StageTimes* times, StepResult& to_result)
      : scene(in_memory.scene), memory(in_memory), result(to_result), times_(times) {}

  const CompiledScene& scene;
  StepMemory& memory;
  StepResult& result;

  bool workLeft() const { return result.work < scene.step_limits.max_work; }

  PairSet search(const Configuration& pose, double margin, PairsOf of);
  /// Makes the rows of leaves and of flat triangles.
  RowSet rows(const PairSet& set, const Configuration& pose, RowForm form, const Eigen::Matrix3d& axes);
  RowSet rows(const PairSet& set, const Configuration& pose);
  /// Removes the pairs whose `rows`, made at the current pose, have a gap above `margin`; the next QP starts from the
  /// same active rows.
  void keepNear(double margin, PairSet& set, RowSet& rows);
  /// Adds the rows of smooth patches within `margin`. The next QP starts from the same active rows; keepActive() must
  /// have been called before.
  void addFelt(const PairSet& set, const Configuration& pose, double margin, RowSet& rows);

  /// Computes the point nearest to `target` that satisfies all rows; the answer is in `memory`. If rows contradict each
  /// other, relaxes them by the smallest common distance [mm] that makes them feasible: first the rows of smooth
  /// patches, which are only for comfort, then all rows. Returns the distance by which all rows were relaxed.
  double solve(RowSet& set, const Vector6& target);
  /// Like solve(), for contacts with friction or objects that yield: the tool starts at `at`, where the rows were made.
  /// Call giveWay() afterwards, with the share of the step that was made.
  double solveContact(const PairSet& pairs, RowSet& rows, const Vector6& target, const Configuration& at, const CarriedPiece* carried);
  bool rubsOrGives() const { return scene.has_friction || scene.has_soft; }
  void giveWay(double share);
  /// Removes all forces on soft tissue and on objects that yield evenly.
  void letGo();
  /// Relaxes rows that the current pose violates, so that staying is feasible.
  void allowStaying(RowSet& set);

  /// Stores the names of the active rows, from which the next QP and the next step start.
  void keepActive(const PairSet& set);
  void findActive(const PairSet& set);

  // The name of a row; the index of a row with this name, or ~0u; its previous friction force.
  RowName nameOfRow(const PairSet& set, std::uint32_t row) const;
  std::uint32_t rowOf(const PairSet& set, const RowName& name) const;
  const Eigen::Vector3d* rubbingOf(const RowName& name) const;
  const PairSet& felt() const { return felt_; }
  bool rubs = true;            // false while the tool moves out of an object, when forces are meaningless
  Configuration contact_pose;  // pose of the tool at which the rows of the last solveContact() were made

  Vector6 scaledVector(const Displacement& d) const;
  Displacement displacement(const Vector6& y) const;
  /// Upper bound of the motion of a point of the tool [mm].
  double reach(const Displacement& d) const { return d.translation.norm() + scene.tool.reach * d.rotation.norm(); }

 private:
  std::uint32_t costOfRow() const;  // in rows of balls
  void shiftSoft(const PairSet& set, std::uint32_t first, RowSet& rows) const;

  StageTimes* times_;
  PairSet felt_;  // of the last addFelt()
};

/// From the reference point to the point of the tool that row `row` touches, whose unit normal is `normal` and whose
/// name is `name`; `rotation` is that of the pose at which the row was made. World axes.
Eigen::Vector3d armOf(const CompiledScene& scene, const RowSet& rows, std::uint32_t row, const RowName& name, const Eigen::Vector3d& normal,
                      const Eigen::Matrix3d& rotation);

void constrainedStep(StepParts& parts, const Configuration& haptic);
void publishedStep(StepParts& parts, const Configuration& haptic);

}  // namespace spheretree::runtime
