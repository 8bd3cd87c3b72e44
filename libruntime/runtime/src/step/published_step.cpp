// SPDX-License-Identifier: Apache-2.0
// Mode paper: D. Wang, X. Zhang, Y. Zhang, J. Xiao. Configuration-based optimization for six degree-of-freedom haptic
// rendering using sphere-trees. IROS 2011. Errors and omissions of the paper, and our solutions: docs/runtime.md
#include <cmath>

#include "state/moving_bodies.h"
#include "step/step_parts.h"

namespace spheretree::runtime {

namespace {

// The angles gamma, beta, alpha of R = Rz(alpha) Ry(beta) Rx(gamma).
Eigen::Vector3d eulerAngles(const Quaternion& q) {
  const Eigen::Matrix3d m = q.toRotationMatrix();
  const double level = std::sqrt(m(0, 0) * m(0, 0) + m(1, 0) * m(1, 0));
  return {std::atan2(m(2, 1), m(2, 2)), std::atan2(-m(2, 0), level), std::atan2(m(1, 0), m(0, 0))};
}

Quaternion fromEuler(const Eigen::Vector3d& e) {
  const Eigen::Array3d half = 0.5 * e.array(), c = half.cos(), s = half.sin();
  return {c[2] * c[1] * c[0] + s[2] * s[1] * s[0], c[2] * c[1] * s[0] - s[2] * s[1] * c[0], c[2] * s[1] * c[0] + s[2] * c[1] * s[0],
          s[2] * c[1] * c[0] - c[2] * s[1] * s[0]};
}

}  // namespace

void publishedStep(StepParts& parts, const Configuration& haptic) {
  StepMemory& memory = parts.memory;
  if (memory.moving_count > 0) advanceBodies(1, memory);
  Eigen::Vector3d before =
      memory.has_euler ? Eigen::Vector3d(memory.euler[0], memory.euler[1], memory.euler[2]) : eulerAngles(memory.graphic.orientation);
  Eigen::Vector3d angles = eulerAngles(haptic.orientation);
  for (int k = 0; k < 3; ++k)  // the number of turns nearest to that of the graphic tool: no jump at +-pi
    angles[k] += 2 * M_PI * std::round((before[k] - angles[k]) / (2 * M_PI));

  const PairSet pairs = parts.search(haptic, 0, PairsOf::LeavesExactly);
  if (pairs.coarse) parts.result.faults |= kPairsFull;
  Eigen::Vector3d position = haptic.position, after = angles;
  memory.answer.active_count = 0;
  if (!pairs.pairs.empty()) {
    // Gamma rotates about the tool's own x axis, alpha about the world's z axis, beta about the y axis after the
    // rotation by alpha.
    Eigen::Matrix3d axes;
    axes << memory.graphic.orientation * Eigen::Vector3d::UnitX(), Eigen::Vector3d(-std::sin(before[2]), std::cos(before[2]), 0),
        Eigen::Vector3d::UnitZ();
    RowSet set = parts.rows(pairs, memory.graphic, RowForm::SquaredDistance, axes);
    parts.findActive(pairs);
    parts.solve(set, parts.scaledVector({haptic.position - memory.graphic.position, angles - before}));
    parts.keepActive(pairs);
    const Displacement step = parts.displacement(memory.answer.y);
    position = memory.graphic.position + step.translation;
    after = before + step.rotation;
  } else {
    memory.active_count = 0;
  }
  memory.has_euler = true;
  memory.euler = {after[0], after[1], after[2]};
  memory.graphic = pairs.pairs.empty() ? haptic : Configuration{position, fromEuler(after)};
  memory.wrench = {parts.scene.coupling.translation * (position - haptic.position), parts.scene.coupling.rotation * (after - angles)};
}

}  // namespace spheretree::runtime
