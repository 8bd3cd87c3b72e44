// SPDX-License-Identifier: Apache-2.0
// What both modes of a step are made of: searches, rows and QPs, with their counts and times; and the modes themselves.
#pragma once

#include "find_pairs.h"
#include "qp6.h"
#include "rows.h"
#include "step_memory.h"

namespace spheretree::runtime {

/// A piece in which bodies go this part of their way, 0: none, and the tool stays but for what pushes it. What it
/// presses with, and so what rubs, is as before.
struct CarriedPiece {
  double part = 0;
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
  /// Rows of leaves and of flat triangles.
  RowSet rows(const PairSet& set, const Configuration& pose, RowForm form, const Eigen::Matrix3d& axes);
  RowSet rows(const PairSet& set, const Configuration& pose) { return rows(set, pose, RowForm::TrueDistance, Eigen::Matrix3d::Identity()); }
  /// Of the pairs those whose `rows`, at this pose, have a gap of at most `margin`; the next QP starts from the same
  /// active rows.
  void keepNear(double margin, PairSet& set, RowSet& rows);
  /// Adds the rows of smooth patches that are within `margin`; the next QP starts from the same active rows, which
  /// keepActive() named.
  void addFelt(const PairSet& set, const Configuration& pose, double margin, RowSet& rows);

  /// Rows for a piece in which the bodies go this part of their way, at the end of which nothing is to be deeper than
  /// it is now: the rows of an object move along with it. `at`: the reference point of the tool.
  void carryRows(const PairSet& set, double part, const Eigen::Vector3d& at, RowSet& rows);
  /// Leaves in the memory the point nearest to `target` that all rows allow. Rows that contradict each other are moved
  /// back by the same distance [mm], the least that lets them agree: those of smooth patches first, for they are there
  /// for comfort only, and then all. Returns the distance of the latter.
  double solve(RowSet& set, const Vector6& target);
  /// As solve(), where contacts rub or objects give way: the tool comes from `at`, where the rows were made. giveWay()
  /// is to follow, with the part of the step that is gone.
  double solveContact(const PairSet& pairs, RowSet& rows, const Vector6& target, const Configuration& at, const CarriedPiece* carried);
  bool rubsOrGives() const { return scene.has_friction || scene.has_soft; }
  void giveWay(double part);
  /// Nothing presses on soft tissue or on what gives way evenly.
  void letGo();
  /// Where the rows forbid even to stay, they allow staying.
  void allowStaying(RowSet& set);

  /// Names of the active rows, which the next QP and the next step start from.
  void keepActive(const PairSet& set);
  void findActive(const PairSet& set);
  /// What the last QP says of the contacts: normals and forces of its active rows, which keepActive() has named. The
  /// tool was at `before` when the step began.
  void noteContacts(const RowSet& set, const Configuration& before);

  // What names a row, and where in the rows it stands, ~0u: nowhere; its force of friction before.
  RowName nameOfRow(const PairSet& set, std::uint32_t row) const;
  std::uint32_t rowOf(const PairSet& set, const RowName& name) const;
  Eigen::Vector3d rubbingOf(const RowName& name) const;
  const PairSet& felt() const { return felt_; }
  bool rubs = true;            // not while the tool is on its way out of an object, where forces mean nothing
  Configuration contact_pose;  // of the tool where the rows of the last solveContact() were made

  Vector6 scaledVector(const Displacement& d) const {
    Vector6 y;
    y << d.translation, scene.angle_length * d.rotation;
    return y;
  }
  Displacement displacement(const Vector6& y) const {
    return {Eigen::Vector3d(y[0], y[1], y[2]), Eigen::Vector3d(y[3], y[4], y[5]) / scene.angle_length};
  }
  /// No point of the tool moves farther than this on the way [mm].
  double reach(const Displacement& d) const { return d.translation.norm() + scene.tool.reach * d.rotation.norm(); }

 private:
  void shiftSoft(const PairSet& set, std::uint32_t first, RowSet& rows) const;

  StageTimes* times_;
  PairSet felt_;  // of the last addFelt()
};

void constrainedStep(StepParts& parts, const Configuration& haptic);
void paperStep(StepParts& parts, const Configuration& haptic);

/// Gamma, beta, alpha of R = Rz(alpha) Ry(beta) Rx(gamma).
Eigen::Vector3d eulerAngles(const Quaternion& q);

}  // namespace spheretree::runtime
