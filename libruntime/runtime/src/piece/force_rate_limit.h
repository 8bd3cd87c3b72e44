// SPDX-License-Identifier: Apache-2.0
// How fast force and torque may change. Where the nearest free pose is not a continuous function of the hand's pose,
// the graphic tool moves to the new pose over several steps.
// Reasons: docs/algorithms/runtime/constrained_step.md#how-fast-the-force-may-change
#pragma once

#include "contact/qp6.h"
#include "spheretree/runtime/scene.h"

namespace spheretree::runtime {

// How much the wrench may change in a step in excess of the change that the motion of the hand explains: half of the
// smallest difference that a hand can perceive, so that a step is not felt.
// Force: 7 % (X.-D. Pang, H. Z. Tan, N. I. Durlach. Manual discrimination of force using active finger motion.
// Perception & Psychophysics 49(6), 1991). Torque: 13 % (L. Jandura, M. A. Srinivasan. Experiments on human performance
// in torque discrimination and control. ASME DSC 55-1, 1994). For small forces and torques the smallest differences are
// taken as the pass figures of docs/stability.md, 0.1 N and 5 N mm.
inline constexpr double kUnnoticed = 0.5;  // share of the smallest perceptible difference that one step may use
inline constexpr double kForceStep = kUnnoticed * 0.1, kForceStepPart = kUnnoticed * 0.07;  // [N], share of the force
inline constexpr double kTorqueStep = kUnnoticed * 5, kTorqueStepPart = kUnnoticed * 0.13;  // [N mm], share of the torque

/// The limit of one step. Stretch: the vector from the graphic tool to the haptic tool, which is proportional to the
/// wrench [mm, scaled].
class ForceRateLimit {
 public:
  /// The hand moves by `hand`. The stretch is `before` at the beginning of the step, and `at_rest` at its end if the
  /// graphic tool rests. `angle_length`: that of the scaled vectors [mm].
  ForceRateLimit(const Coupling& pull, double angle_length, const Vector6& before, const Vector6& hand, const Vector6& at_rest);

  /// From now on any change is allowed.
  void lift();
  /// A body moves by this at the tool: that explains a change, as the motion of the hand does.
  void allow(const Vector6& motion);
  /// The largest share, up to `max_share`, of the piece `way` after which the stretch has changed by no more than the
  /// limit. `stretch`: at the beginning of the piece.
  double shareWithin(const Vector6& stretch, const Vector6& way, double max_share) const;

 private:
  Vector6 before_;
  double both_, force_, torque_;  // largest change of all six components, of the translation, of the rotation [mm, scaled]
};

}  // namespace spheretree::runtime
