// SPDX-License-Identifier: Apache-2.0
// How much the wrench may change in a step beyond what the motion of the hand explains.
// A hand at rest tells two forces apart that differ by 7 % (10 % where they are small), two torques by 13 %: X.-D.
// Pang, H. Z. Tan, N. I. Durlach, Manual discrimination of force using active finger motion, Perception & Psychophysics
// 49(6), 1991; L. A. Jones, Matching forces, Perception 18(5), 1989. Below about 1 N and 40 N mm the difference no
// longer shrinks: 0.1 N and 5 N mm (docs/stability.md). A step of two fifths of that stays unnoticed, and so do two of
// them at once.
#pragma once

namespace spheretree::runtime {

inline constexpr double kForceStep = 0.5 * 0.1, kForceStepPart = 0.5 * 0.07;  // [N], of the force
inline constexpr double kTorqueStep = 0.4 * 5, kTorqueStepPart = 0.4 * 0.13;  // [N mm], of the torque

}  // namespace spheretree::runtime
