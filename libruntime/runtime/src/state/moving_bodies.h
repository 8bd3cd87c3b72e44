// SPDX-License-Identifier: Apache-2.0
// Bodies and their motion to new poses during a step. The pose of a body is the displacement of its objects from their
// poses in the scene: x becomes orientation * x + position. Units: mm, rad, s; world axes.
//
// A body is away if the ball around its objects stays clear of the ball around the tool on its whole way. It goes to
// its target at once, since nothing can be between the two; its objects follow when a search comes near its ball.
#pragma once

#include "spheretree/core/rigid.h"
#include "state/moving_body.h"

namespace spheretree::runtime {

struct StepMemory;

/// Makes the balls of all bodies, once the objects are where they begin. Cost: about 10 ns an object.
void encloseBodies(StepMemory& memory);
/// Moves an object to a pose at once.
[[gnu::cold]] void placeObject(std::size_t object, const Configuration& pose, StepMemory& memory);
/// Switches an object on, where its body is now, or off.
[[gnu::cold]] void switchObject(std::size_t object, bool is_active, StepMemory& memory);
/// Places the views of the object where its body is now.
void follow(std::size_t object, StepMemory& memory);

/// Gives a body its next pose and determines where its ball will be. Cost: about 20 ns.
void aimBody(MovingBody& body, const Configuration& to);
/// At the start of a step: determines which bodies are away, and the remaining displacement of the others. Cost: about
/// 10 ns for each body that moves and is away, 100 ns for one that is near.
void startMotions(StepMemory& memory);
BodyMotion motionLeft(const StepMemory& memory);
/// Motion of a point at `x` that is fixed to the body, and of its surroundings, for this share of the remaining
/// displacement.
Displacement motionAt(const MovingBody& body, double share, const Eigen::Vector3d& x);
/// Moves the bodies that are not away by this share of their remaining displacements; 1: to the end. Cost: about 15 ns
/// an object.
void advanceBodies(double share, StepMemory& memory);
/// Ends the absence of a body: its objects are where its pose says. Cost: none if it is not away.
void show(MovingBody& body, StepMemory& memory);
/// Ends the absence of bodies whose ball is within `reach` [mm] of `centre`. Cost: none if all are farther away.
void bringNear(const Eigen::Vector3d& centre, double reach, StepMemory& memory);

}  // namespace spheretree::runtime
