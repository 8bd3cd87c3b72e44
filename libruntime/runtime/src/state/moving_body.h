// SPDX-License-Identifier: Apache-2.0
// The state of a body that moves objects; moving_bodies.h moves it. Units: mm, rad, s; world axes.
#pragma once

#include <cstdint>

#include "spheretree/core/rigid.h"

namespace spheretree::runtime {

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

}  // namespace spheretree::runtime
