// SPDX-License-Identifier: Apache-2.0
#include "moving_bodies.h"

#include <algorithm>

#include "step_memory.h"

namespace spheretree::runtime {

namespace {

bool isNone(const Displacement& d) { return d.translation.squaredNorm() + d.rotation.squaredNorm() == 0; }

}  // namespace

void startMotions(StepMemory& memory) {
  memory.bodies_move = false;
  for (MovingBody& body : memory.bodies) {
    const double seconds = memory.scene.step_time;
    if (!body.has_new_pose && !isNone(body.velocity))
      body.to = moved(body.to, {seconds * body.velocity.translation, seconds * body.velocity.rotation});
    body.has_new_pose = false;
    body.before = body.now;
    body.left = displacementBetween(body.now, body.to);
    body.length = 0;
    body.moves = !isNone(body.left);
    memory.bodies_move = memory.bodies_move || body.moves;
  }
  if (!memory.bodies_move) return;
  for (const CompiledObject& object : memory.objects) {
    MovingBody& body = memory.bodies[object.body];
    if (!body.moves) continue;
    const double arm = (object.anchor - body.now.position).norm() + memory.scene.shapes[object.shape].radius;
    body.length = std::max(body.length, body.left.translation.norm() + body.left.rotation.norm() * arm);
  }
}

BodyMotion motionLeft(const StepMemory& memory) {
  BodyMotion most;
  for (const MovingBody& body : memory.bodies)
    if (body.moves) most = {std::max(most.length, body.length), std::max(most.turn, body.left.rotation.norm())};
  return most;
}

Displacement motionAt(const MovingBody& body, double part, const Eigen::Vector3d& x) {
  const Eigen::Vector3d arm = x - body.now.position, turn = part * body.left.rotation;
  return {part * body.left.translation + rotationOf(turn) * arm - arm, turn};
}

void StepMemory::carry(std::size_t i, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& position) {
  CompiledObject& object = objects[i];
  object.rotation = rotation * at_home[i].rotation;
  object.anchor = rotation * at_home[i].anchor + position;
  Block& root = object_roots[i / 8];
  put(root, i % 8, object.anchor, root.r[i % 8]);
  farthest_anchor = std::max(farthest_anchor, object.anchor.norm());
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) leaf_views[i].to_world[3 * r + c] = views[i].to_world[3 * r + c] = object.rotation(r, c);
}

void advanceBodies(double part, StepMemory& memory) {
  memory.bodies_move = part < 1;
  for (std::uint32_t b = 1; b < memory.bodies.size(); ++b) {
    MovingBody& body = memory.bodies[b];
    if (!body.moves) continue;
    body.now = part < 1 ? moved(body.now, {part * body.left.translation, part * body.left.rotation}) : body.to;
    body.left = {(1 - part) * body.left.translation, (1 - part) * body.left.rotation};
    body.length *= 1 - part;
    body.moves = part < 1;
    body.rotation = body.now.orientation.toRotationMatrix();
    body.was_moved = true;
  }
  for (std::size_t i = 0; i < memory.objects.size(); ++i) {
    const MovingBody& body = memory.bodies[memory.objects[i].body];
    if (body.was_moved) memory.carry(i, body.rotation, body.now.position);
  }
  for (MovingBody& body : memory.bodies) body.was_moved = false;
}

}  // namespace spheretree::runtime
