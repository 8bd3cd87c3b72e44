// SPDX-License-Identifier: GPL-3.0-or-later
// Static virtual coupling: the graphic tool is at the equilibrium of the spring to the hand and the penalty forces,
// found by one linearised step in each cycle.
// Paper: J. Barbic, D. L. James. Six-DoF haptic rendering of contact between geometrically complex reduced deformable
// models. IEEE Transactions on Haptics 1(1), 2008, section 6 (static virtual coupling).
// Units: mm, N, N mm, rad.
#pragma once

#include <Eigen/Core>

#include "published/renderer.h"

namespace spheretree::player {

/// The penalty wrench on the tool at a pose, about the reference point, and its stiffness.
struct Penalty {
  Eigen::Matrix<double, 6, 1> wrench = Eigen::Matrix<double, 6, 1>::Zero();     // force, torque
  Eigen::Matrix<double, 6, 6> stiffness = Eigen::Matrix<double, 6, 6>::Zero();  // minus the derivative by (translation, rotation)
  std::uint32_t contacts = 0;

  /// Adds a force of `size` along `direction` at `arm` from the reference point. It decreases by `slope` for each mm
  /// that its point of application moves along `fall`.
  void add(const Eigen::Vector3d& arm, const Eigen::Vector3d& direction, double size, const Eigen::Vector3d& fall, double slope);
};

/// Solves (K_spring + K_penalty) step = spring + penalty at `graphic`, and moves `graphic` by the step.
Configuration balanced(const runtime::Coupling& coupling, const Configuration& haptic, const Configuration& graphic,
                       const Penalty& penalty);

/// A renderer with penalty forces: a derived class computes the penalty at a pose, and this class adds the coupling.
class PenaltyRenderer : public Renderer {
 protected:
  using Renderer::Renderer;
  virtual Penalty penaltyAt(const Configuration& tool) const = 0;
  std::uint32_t follow(const Configuration& haptic) final;
};

}  // namespace spheretree::player
