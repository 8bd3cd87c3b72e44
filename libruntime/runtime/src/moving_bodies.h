// SPDX-License-Identifier: Apache-2.0
// Bodies and their motion to new poses during a step. The pose of a body is the displacement of its objects from their
// poses in the scene: x becomes orientation * x + position. Units: mm, rad, s; world axes.
//
// A body is away if the ball around its objects stays clear of the ball around the tool on its whole way. It goes to
// its target at once, since nothing can be between the two; its objects follow when a search comes near its ball.
#pragma once

#include <cstdint>

#include "spheretree/core/rigid.h"

namespace spheretree::runtime {

struct StepMemory;

struct MovingBody {
  // What a step reads of a body that is away comes first.
  double middle[3] = {0, 0, 0}, radius = 0;  // ball around its objects at `to`, in the world [mm]
  double way = 0;                            // bound of the ball's way to there [mm]
  bool has_new_pose = false, moves = false, is_away = false;
  bool was_moved = false;                                  // in this step or the last one: `before` may not be `now`
  std::uint32_t first_object = ~0u;                        // CompiledObject::next_of_body leads to the others
  std::uint32_t pose_count = 0;                            // changes with each move; CompiledObject::placed_for lags behind it
  Configuration now, to;                                   // during a step the body moves from `now` to `to`
  Configuration before;                                    // pose at the beginning of the step, unless it is away
  Displacement velocity;                                   // used in steps without a new pose
  Displacement left;                                       // remaining displacement from `now` to `to`, rotation about `now.position`
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // of `now`, unless the body is away
  double length = 0;                                       // bound of the remaining way of a point of its objects [mm]
  double centre[3] = {0, 0, 0}, arm = 0;                   // of the ball, in the axes of the body; |centre| [mm]

  /// A body that is away has arrived at `to` unless it has got a new pose since; `now` follows later.
  const Configuration& pose() const { return is_away && !has_new_pose ? to : now; }
};

/// Upper bounds of the way of a point and of the angle of rotation, over all moving bodies.
struct BodyMotion {
  double length = 0, turn = 0;
};

/// Makes the ball of a body; and extends it to an object that joins. Cost: about 10 ns an object.
void encloseObjects(MovingBody& body, const StepMemory& memory);
void joinBody(std::size_t object, MovingBody& body, const StepMemory& memory);

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
