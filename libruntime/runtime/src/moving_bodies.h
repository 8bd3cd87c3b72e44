// SPDX-License-Identifier: Apache-2.0
// Bodies, and how they go to new poses during a step. The pose of a body is the displacement of its objects from where
// the scene has them at its start: x goes to orientation * x + position. Units: mm, rad, s; world axes.
#pragma once

#include "spheretree/core/rigid.h"

namespace spheretree::runtime {

struct StepMemory;

struct MovingBody {
  Configuration now, to;                                   // on the way from the one to the other during a step
  Configuration before;                                    // where it was when the step began
  Displacement velocity;                                   // in steps without a new pose
  Displacement left;                                       // from now to `to`, the rotation about `now.position`
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // of `now`
  double length = 0;                                       // no point of its objects goes farther on what is left [mm]
  bool has_new_pose = false, moves = false, was_moved = false;
};

/// No point of a moving body goes farther, and none turns more.
struct BodyMotion {
  double length = 0, turn = 0;
};

/// At the start of a step: what each body has to go. Cost: about 10 ns for each object of a body that moves.
void startMotions(StepMemory& memory);
BodyMotion motionLeft(const StepMemory& memory);
/// How a point fixed to the body that is at `x` now, and what is about it, moves on this part of what is left.
Displacement motionAt(const MovingBody& body, double part, const Eigen::Vector3d& x);
/// All go this part of what is left, and take their objects along; 1: to the end. Cost: about 30 ns an object.
void advanceBodies(double part, StepMemory& memory);

}  // namespace spheretree::runtime
