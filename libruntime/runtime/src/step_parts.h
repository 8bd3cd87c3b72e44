// SPDX-License-Identifier: Apache-2.0
// What both modes of a step are made of: searches, rows and QPs, with their counts and times; and the modes themselves.
#pragma once

#include "spheretree/runtime/collide.h"
#include "spheretree/runtime/contact.h"
#include "spheretree/runtime/qp6.h"
#include "spheretree/runtime/step.h"

namespace spheretree::runtime {

class StepParts {
 public:
  StepParts(const Scene& of_scene, Workspace& in_workspace, StageTimes* times, StepResult& to_result)
      : scene(of_scene), workspace(in_workspace), result(to_result), times_(times) {}

  const Scene& scene;
  Workspace& workspace;
  StepResult& result;

  bool workLeft() const { return result.work < scene.step_limits.max_work; }

  PairSet search(const Configuration& pose, double margin, bool exact);
  /// Finds the bridges that can be touched within `margin` of a pose at which search() was not coarse.
  void searchBridges(const Configuration& pose, double margin);
  /// Only what is within `margin` of the pose at which `rows` were made stays. After keepActive(): the next QP starts from the same rows.
  void narrowTo(double margin, const RowSet& rows, const Configuration& pose, PairSet& set);
  bool isFree(const PairSet& set) const { return set.pairs.empty() && bridges_.pairs.empty(); }
  bool anyBridges() const { return !bridges_.pairs.empty(); }

  RowSet rows(const PairSet& set, const Configuration& pose, RowForm form, const Eigen::Matrix3d& axes);
  RowSet rows(const PairSet& set, const Configuration& pose) { return rows(set, pose, RowForm::TrueDistance, Eigen::Matrix3d::Identity()); }
  /// Rows of pairs and of bridges.
  RowSet allRows(const PairSet& set, const Configuration& pose, double margin);

  /// Leaves in the workspace the point nearest to `target` that all rows allow. Rows that contradict each other are moved back by the same
  /// distance [mm], the least that lets them agree: those of bridges first, for they are there for comfort only, and then all. Returns the
  /// distance of the latter.
  double solve(const RowSet& set, const Vector6& target);
  /// Where the rows forbid even to stay, they allow staying.
  void allowStaying(const RowSet& set);

  /// Names of the active rows, which the next QP and the next step start from.
  void keepActive(const PairSet& set);
  void findActive(const PairSet& set);

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
  StageTimes* times_;
  PairSet bridges_;  // near the pose of the last searchBridges()
};

void constrainedStep(StepParts& parts, const Configuration& haptic);
void paperStep(StepParts& parts, const Configuration& haptic);

/// Gamma, beta, alpha of R = Rz(alpha) Ry(beta) Rx(gamma).
Eigen::Vector3d eulerAngles(const Quaternion& q);

}  // namespace spheretree::runtime
