// SPDX-License-Identifier: Apache-2.0
// Bodies and their motion to new poses during a step. The pose of a body is the displacement of its objects from their
// poses in the scene: x becomes orientation * x + position. Units: mm, rad, s; world axes.
#pragma once

#include "spheretree/core/rigid.h"

namespace spheretree::runtime {

struct StepMemory;

struct MovingBody {
  Configuration now, to;                                   // during a step the body moves from `now` to `to`
  Configuration before;                                    // pose at the beginning of the step
  Displacement velocity;                                   // used in steps without a new pose
  Displacement left;                                       // remaining displacement from `now` to `to`, rotation about `now.position`
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // of `now`
  double length = 0;                                       // largest remaining way of a point of its objects [mm]
  bool has_new_pose = false, moves = false, was_moved = false;
};

/// Upper bounds of the way of a point and of the angle of rotation, over all moving bodies.
struct BodyMotion {
  double length = 0, turn = 0;
};

/// At the start of a step: determines the remaining displacement of each body. Cost: about 10 ns for each object of a
/// moving body.
void startMotions(StepMemory& memory);
BodyMotion motionLeft(const StepMemory& memory);
/// Motion of a point at `x` that is fixed to the body, and of its surroundings, for this part of the remaining
/// displacement.
Displacement motionAt(const MovingBody& body, double part, const Eigen::Vector3d& x);
/// Moves all bodies and their objects by this part of their remaining displacements; 1: to the end. Cost: about 30 ns
/// an object.
void advanceBodies(double part, StepMemory& memory);

}  // namespace spheretree::runtime
