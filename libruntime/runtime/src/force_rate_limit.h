// SPDX-License-Identifier: Apache-2.0
// How much the wrench may change in a step in excess of the change that the motion of the hand explains: half of the
// smallest difference that a hand can perceive, so that a step is not felt.
// Force: 7 % (X.-D. Pang, H. Z. Tan, N. I. Durlach. Manual discrimination of force using active finger motion.
// Perception & Psychophysics 49(6), 1991). Torque: 13 % (L. Jandura, M. A. Srinivasan. Experiments on human performance
// in torque discrimination and control. ASME DSC 55-1, 1994). For small forces and torques the smallest differences are
// taken as the pass figures of docs/stability.md, 0.1 N and 5 N mm.
#pragma once

namespace spheretree::runtime {

inline constexpr double kUnnoticed = 0.5;  // share of the smallest perceptible difference that one step may use
inline constexpr double kForceStep = kUnnoticed * 0.1, kForceStepPart = kUnnoticed * 0.07;  // [N], share of the force
inline constexpr double kTorqueStep = kUnnoticed * 5, kTorqueStepPart = kUnnoticed * 0.13;  // [N mm], share of the torque

}  // namespace spheretree::runtime
