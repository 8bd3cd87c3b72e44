// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/static_coupling.h"

#include <Eigen/LU>

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

std::uint32_t PenaltyRenderer::follow(const Configuration& haptic) {
  const Penalty penalty = penaltyAt(graphic_);
  graphic_ = balanced(coupling_, haptic, graphic_, penalty);
  return penalty.contacts;
}

}  // namespace spheretree::player
