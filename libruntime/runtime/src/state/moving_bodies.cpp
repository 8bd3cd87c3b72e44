// SPDX-License-Identifier: Apache-2.0
#include "state/moving_bodies.h"

#include <algorithm>

#include "state/step_memory.h"

namespace spheretree::runtime {

namespace {

constexpr double kApart = 1e-3;          // rounding errors at 1e7 mm from the origin are below it [mm]
constexpr double kTurnOfChord = 2.2215;  // pi / sqrt(2): an angle is at most this times the distance of the quaternions

bool isNone(const Displacement& d) { return d.translation.squaredNorm() + d.rotation.squaredNorm() == 0; }

double squaredDistance(const double* a, const double* b) {
  return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]);
}

// Extends the ball of a body to an object that joins.
void joinBody(std::size_t i, MovingBody& body, const StepMemory& memory) {
  const CompiledObject& object = memory.at_home[i];
  const double reach = std::sqrt(squaredDistance(object.anchor.data(), body.centre)) + memory.scene.shapes[object.shape].radius;
  body.radius = std::max(body.radius, reach * (1 + 1e-6));
}

void enclose(MovingBody& body, const StepMemory& memory) {
  int count = 0;
  for (std::uint32_t i = body.first_object; i != ~0u; i = memory.at_home[i].next_of_body, ++count)
    for (int k = 0; k < 3; ++k) body.centre[k] = (body.centre[k] * count + memory.at_home[i].anchor[k]) / (count + 1);
  body.arm = std::sqrt(body.centre[0] * body.centre[0] + body.centre[1] * body.centre[1] + body.centre[2] * body.centre[2]);
  for (std::uint32_t i = body.first_object; i != ~0u; i = memory.at_home[i].next_of_body) joinBody(i, body, memory);
}

// Bounding spheres and anchors of the objects of a body that moved; the rest follows when a search comes near to one.
void moveObjects(MovingBody& body, StepMemory& memory) {
  body.rotation = body.now.orientation.toRotationMatrix();
  ++body.pose_count;
  memory.farthest_anchor = std::max(memory.farthest_anchor, body.now.position.norm() + body.arm + body.radius);
  const Eigen::Matrix3d r = body.rotation;  // copies, so that the stores below cannot change them
  const Eigen::Vector3d p = body.now.position;
  for (std::uint32_t i = body.first_object; i != ~0u; i = memory.at_home[i].next_of_body) {
    const double* const home = memory.at_home[i].anchor.data();
    double* const anchor = memory.objects[i].anchor.data();
    for (int k = 0; k < 3; ++k) anchor[k] = r(k, 0) * home[0] + r(k, 1) * home[1] + r(k, 2) * home[2] + p[k];
    Block& root = memory.object_roots[i / 8];
    put(root, i % 8, memory.objects[i].anchor, root.r[i % 8]);
    if (memory.tissue) follow(i, memory);
  }
}

void sendAway(MovingBody& body, StepMemory& memory) {
  body.is_away = true;
  ++memory.away_count;
  for (std::uint32_t i = body.first_object; i != ~0u; i = memory.at_home[i].next_of_body) memory.object_roots[i / 8].x[i % 8] = kFarAway;
}

}  // namespace

void encloseBodies(StepMemory& memory) {
  for (MovingBody& body : memory.bodies) enclose(body, memory);
}

void follow(std::size_t i, StepMemory& memory) {
  CompiledObject& at_home = memory.at_home[i];
  const MovingBody& body = memory.bodies[at_home.body];
  if (at_home.placed_for == body.pose_count) return;
  at_home.placed_for = body.pose_count;
  const Eigen::Matrix3d &r = body.rotation, &home = at_home.rotation;
  for (int k = 0; k < 3; ++k)
    for (int c = 0; c < 3; ++c) {
      const double value = r(k, 0) * home(0, c) + r(k, 1) * home(1, c) + r(k, 2) * home(2, c);
      memory.leaf_views[i].to_world[3 * k + c] = memory.views[i].to_world[3 * k + c] = memory.objects[i].rotation(k, c) = value;
    }
}

void show(MovingBody& body, StepMemory& memory) {
  if (!body.is_away) return;
  body.now = body.pose();
  body.is_away = false;
  --memory.away_count;
  moveObjects(body, memory);
}

// No point on the path of the ball's centre is farther from its end than the bound of its length.
void aimBody(MovingBody& body, const Configuration& to) {
  body.now = body.pose();
  body.to = to;
  body.has_new_pose = true;
  const double *q = body.to.orientation.coeffs().data(), *p = body.now.orientation.coeffs().data(), *c = body.centre;
  const double t[3] = {2 * (q[1] * c[2] - q[2] * c[1]), 2 * (q[2] * c[0] - q[0] * c[2]), 2 * (q[0] * c[1] - q[1] * c[0])};
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    body.middle[i] = c[i] + q[3] * t[i] + (q[j] * t[k] - q[k] * t[j]) + body.to.position[i];
  }
  const double chord2 = std::max(0.0, 2 - 2 * std::abs(q[0] * p[0] + q[1] * p[1] + q[2] * p[2] + q[3] * p[3]));
  body.way = std::sqrt(squaredDistance(body.to.position.data(), body.now.position.data())) + kTurnOfChord * std::sqrt(chord2) * body.arm;
}

void startMotions(StepMemory& memory) {
  memory.moving_count = 0;
  memory.away_from = memory.graphic.orientation * memory.scene.tool_root + memory.graphic.position;
  memory.away_by = static_cast<double>(kFarAway);
  const double seconds = memory.scene.step_time, tool_radius = memory.scene.tool_root_radius + kApart;
  for (MovingBody& body : memory.bodies) {
    if (!body.has_new_pose && !isNone(body.velocity))
      aimBody(body, moved(body.to, {seconds * body.velocity.translation, seconds * body.velocity.rotation}));
    if (!body.has_new_pose && !body.was_moved && !body.is_away) continue;
    body.was_moved = body.has_new_pose || body.moves;
    const double apart = std::sqrt(squaredDistance(body.middle, memory.away_from.data())) - body.radius;
    const bool is_far = apart > tool_radius + (body.was_moved ? body.way : 0) && !memory.tissue;
    if (is_far && !body.is_away) sendAway(body, memory);
    if (!is_far) show(body, memory);
    body.has_new_pose = body.moves = false;
    if (is_far) {
      memory.away_by = std::min(memory.away_by, apart);
      continue;
    }
    body.before = body.now;
    body.left = displacementBetween(body.now, body.to);
    body.moves = !isNone(body.left);
    if (!body.moves) continue;
    memory.moving[memory.moving_count++] = &body;
    body.length = body.left.translation.norm() + body.left.rotation.norm() * (body.arm + body.radius);
  }
}

BodyMotion motionLeft(const StepMemory& memory) {
  BodyMotion largest;
  for (const MovingBody* body : memory.movingBodies())
    largest = {std::max(largest.length, body->length), std::max(largest.turn, body->left.rotation.norm())};
  return largest;
}

Displacement motionAt(const MovingBody& body, double share, const Eigen::Vector3d& x) {
  const Eigen::Vector3d arm = x - body.now.position, turn = share * body.left.rotation;
  return {share * body.left.translation + rotationOf(turn) * arm - arm, turn};
}

void advanceBodies(double share, StepMemory& memory) {
  for (MovingBody* const body : memory.movingBodies()) {
    body->now = share < 1 ? moved(body->now, {share * body->left.translation, share * body->left.rotation}) : body->to;
    body->left = {(1 - share) * body->left.translation, (1 - share) * body->left.rotation};
    body->length *= 1 - share;
    body->moves = share < 1;
    moveObjects(*body, memory);
  }
  if (!(share < 1)) memory.moving_count = 0;
  for (const PairRun& run : memory.runs) follow(run.object, memory);
}

void bringNear(const Eigen::Vector3d& centre, double reach, StepMemory& memory) {
  if (memory.away_count == 0 || (centre - memory.away_from).norm() + reach + kApart < memory.away_by) return;
  for (MovingBody& body : memory.bodies) {
    const double largest = body.radius + reach + kApart;
    if (squaredDistance(body.middle, centre.data()) <= largest * largest) show(body, memory);
  }
}

void switchObject(std::size_t i, bool is_active, StepMemory& memory) {
  if (memory.isActive(i) == is_active) return;
  memory.feelSkin(i);
  if (!is_active) return memory.switchOff(i);
  show(memory.bodies[memory.objects[i].body], memory);
  follow(i, memory);
  memory.switchOn(i);
  memory.sides_known = false;  // the tool may be anywhere, inside of it too
}

void placeObject(std::size_t i, const Configuration& pose, StepMemory& memory) {
  show(memory.bodies[memory.objects[i].body], memory);
  follow(i, memory);
  const CompiledObject before = memory.objects[i];
  memory.objects[i] = memory.scene.placed(before.shape, before.body, pose);
  memory.placeViews(i);
  const Configuration& body = memory.bodies[before.body].pose();
  const Eigen::Matrix3d to_body = memory.bodies[before.body].rotation.transpose();
  memory.at_home[i].rotation = to_body * memory.objects[i].rotation;
  memory.at_home[i].anchor = to_body * (memory.objects[i].anchor - body.position);
  joinBody(i, memory.bodies[before.body], memory);
  // A motion of more than half of a ball may carry something through its centre: then the side of the tool is
  // determined again.
  const double chord = (memory.objects[i].rotation - before.rotation).norm() / std::sqrt(8.0),  // sine of half the angle
      turn = 2 * std::asin(std::min(1.0, chord)),
               farthest = (memory.objects[i].anchor - before.anchor).norm() + turn * memory.scene.shapes[before.shape].radius;
  if (farthest < 0.5 * memory.scene.min_contact) return;
  memory.sides_known = false;
  memory.feelSkin(i);
}

}  // namespace spheretree::runtime
