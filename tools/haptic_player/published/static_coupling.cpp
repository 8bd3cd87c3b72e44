// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/static_coupling.h"

#include <Eigen/LU>

#include "coupling_wrench.h"

namespace spheretree::player {

using Vector6 = Eigen::Matrix<double, 6, 1>;

void Penalty::add(const Eigen::Vector3d& arm, const Eigen::Vector3d& direction, double size, const Eigen::Vector3d& fall, double slope) {
  Vector6 pushed, moved;
  pushed << direction, arm.cross(direction);
  moved << fall, arm.cross(fall);
  wrench += size * pushed;
  stiffness += slope * pushed * moved.transpose();
  ++contacts;
}

Configuration balanced(const runtime::Coupling& coupling, const Configuration& haptic, const Configuration& graphic,
                       const Penalty& penalty) {
  const Displacement way = displacementBetween(graphic, haptic);
  Vector6 force;
  force << coupling.translation * way.translation, coupling.rotation * way.rotation;
  Eigen::Matrix<double, 6, 6> stiffness = penalty.stiffness;
  for (int k = 0; k < 3; ++k) {
    stiffness(k, k) += coupling.translation;
    stiffness(k + 3, k + 3) += coupling.rotation;
  }
  const Vector6 step = stiffness.partialPivLu().solve(force + penalty.wrench);
  if (!step.allFinite()) return graphic;
  return moved(graphic, {step.head<3>(), step.tail<3>()});
}

runtime::StepResult resultOf(const runtime::Coupling& coupling, const Configuration& haptic, const Configuration& graphic,
                             std::uint32_t contacts) {
  runtime::StepResult result;
  result.graphic = graphic;
  result.wrench = result.limited_wrench = runtime::couplingWrench(coupling, haptic, graphic);
  result.pairs = result.rows = result.active = contacts;
  return result;
}

}  // namespace spheretree::player
