// SPDX-License-Identifier: Apache-2.0
#include "step/tool_path.h"

#include <algorithm>

#include "state/moving_bodies.h"

namespace spheretree::runtime {
namespace {

constexpr int kMaxLinearisations = 48;  // linearisations in one step

}  // namespace

Configuration after(double share, const Displacement& step, const Configuration& from) {
  return moved(from, {share * step.translation, share * step.rotation});
}

ToolPath::ToolPath(StepParts& of_parts, const Configuration& to_haptic)
    : ToolPath(of_parts, to_haptic, displacementBetween(of_parts.memory.haptic, to_haptic),
               displacementBetween(of_parts.memory.graphic, to_haptic)) {}

ToolPath::ToolPath(StepParts& of_parts, const Configuration& to_haptic, const Displacement& hand_motion, const Displacement& to_hand)
    : parts(of_parts),
      haptic(to_haptic),
      start(parts.memory.graphic),
      limits(parts.scene.min_contact, parts.scene.tool.reach,
             ForceRateLimit(parts.scene.pull, parts.scene.angle_length,
                            parts.scaledVector(displacementBetween(parts.memory.graphic, parts.memory.haptic)),
                            parts.scaledVector(hand_motion), parts.scaledVector(to_hand))),
      margin(parts.reach(to_hand), parts.reach(hand_motion), parts.memory.active_count > 0),
      now_(start) {
  const StepMemory& memory = parts.memory;
  if (memory.is_behind) limits.force.lift();  // a tool that did not arrive because the work ran out may catch up
  // Along surfaces that already hold it, the tool moves about as far as the hand.
  if (memory.active_count > 0 && !memory.is_behind && memory.moving_count == 0) margin.feelWithin(1.5 * parts.reach(hand_motion));
}

Displacement ToolPath::way() const { return displacementBetween(now_, haptic); }

bool ToolPath::mayGoOn() const {
  if (parts.result.linearisations < kMaxLinearisations && parts.workLeft()) return true;
  parts.result.faults |= kWorkLimit;
  return false;
}

bool ToolPath::search() {
  for (;;) {
    pairs_ = parts.search(now_, margin.value(), PairsOf::ContactSurface);
    if (!pairs_.coarse) {
      rows_ = parts.rows(pairs_, now_);
      dropFar();
    }
    if (isFree() || !parts.workLeft() || !margin.shorten(pairs_.coarse)) break;
  }
  if (pairs_.coarse) {
    parts.result.faults |= parts.workLeft() ? kPairsFull : kWorkLimit;
    if (parts.workLeft() && !best_.isKnown()) moveCoarsely();
    return false;
  }
  addFelt();
  if (depth_ > kGapTolerance) {
    limits.force.allow(Vector6::Constant(depth_));  // the way out
    was_inside_ = true;
  }
  margin.searched();
  record();
  return true;
}

// Inner nodes replace whole branches, as the balls around their leaves: none may come closer than it is. This only
// steers and proves nothing; therefore the step is tiny, and is made only if a complete search for overlapping leaf
// pairs finds none.
void ToolPath::moveCoarsely() {
  StepMemory& memory = parts.memory;
  parts.findActive(pairs_);
  RowSet set = parts.rows(pairs_, now_);
  parts.allowStaying(set);
  parts.solve(set, scaledWay());
  parts.keepActive(pairs_);
  const Displacement step = parts.displacement(memory.answer.y);
  const double largest = std::min({kMinMargin, limits.depth, 0.25 * parts.scene.min_contact}), length = parts.reach(step),
               turn = step.rotation.norm();
  double share = 1;
  if (length > largest) share = largest / length;
  if (turn * share > limits.turn) share = limits.turn / turn;
  const Configuration to = after(share, step, now_);
  const PairSet touching = parts.search(to, 0, PairsOf::ContactSurface);
  if (touching.coarse) return;
  const double depth = std::max(0.0, -static_cast<double>(parts.rows(touching, to).smallest_gap));
  if (depth > 0.5 * kGapTolerance) return;
  memory.graphic = to;
  parts.result.penetration = depth;
}

void ToolPath::record() {
  best_.record(now_, depth_);
  if (std::max(depth_, felt_depth_) > 0.5 * kGapTolerance) return;
  const double left = scaledWay().norm();
  if (left < nearest_left_) nearest_ = now_, nearest_left_ = left;
}

void ToolPath::returnToNearest() {
  if (!(nearest_left_ < scaledWay().norm()) || parts.rubsOrGives()) return;
  const double back = parts.reach(displacementBetween(now_, nearest_));
  if (knowsContacts() && back <= margin.left()) {
    margin.use(back);
    moveTo(nearest_);
    makeRows();
    record();
  } else if (parts.workLeft()) {
    moveTo(nearest_);
    search();
  }
}

double ToolPath::solve(const Vector6& want) {
  parts.rubs = depth_ <= limits.depth;
  return parts.rubsOrGives() ? parts.solveContact(pairs_, rows_, want, now_, nullptr) : parts.solve(rows_, want);
}

void ToolPath::carryRows(double share) {
  parts.allowStaying(rows_);
  carryRows(pairs_, 0, share);
  carryRows(parts.felt(), rows_.guarded, share);
}

// Row i states a_i . y >= b_i for the tool's step y. If the object makes a step z, expressed as a step about the same
// point, y - z replaces y.
void ToolPath::carryRows(const PairSet& set, std::uint32_t first, double share) {
  for (const PairRun& run : set.runs) {
    const MovingBody& body = parts.memory.bodies[parts.memory.objects[run.object].body];
    if (!body.moves) continue;
    const Vector6 z = parts.scaledVector(motionAt(body, share, now_.position));
    for (std::uint32_t i = first + run.begin; i < first + run.begin + run.count; ++i) {
      double along = 0;
      for (std::size_t k = 0; k < 6; ++k) along += static_cast<double>(rows_.rows.a[k][i]) * z[static_cast<Eigen::Index>(k)];
      rows_.b[i] += static_cast<float>(along);
    }
  }
}

Displacement ToolPath::pushed(double share) {
  const CarriedPiece carried{share};
  if (parts.rubsOrGives())
    parts.solveContact(pairs_, rows_, Vector6::Zero(), now_, &carried);
  else
    parts.solve(rows_, Vector6::Zero());
  parts.keepActive(pairs_);
  return parts.displacement(parts.memory.answer.y);
}

void ToolPath::makeRows() {
  rows_ = parts.rows(pairs_, now_);
  addFelt();
}

void ToolPath::addFelt() {
  parts.addFelt(pairs_, now_, std::min(margin.value(), margin.feltReach()), rows_);
  depth_ = std::max(0.0, -static_cast<double>(rows_.smallest_gap));
  felt_depth_ = std::max(0.0, -static_cast<double>(rows_.smallest_felt_gap));
}

}  // namespace spheretree::runtime
