// SPDX-License-Identifier: Apache-2.0
#include "step/carry_tool.h"

#include <algorithm>
#include <cmath>

#include "state/moving_bodies.h"

namespace spheretree::runtime {
namespace {

constexpr int kMaxShorter = 5;  // attempts of a piece with moving bodies, each shorter

// In the frame of an object a piece is as safe as one of Approach: the row holds at its start and at its end. The row
// neglects terms of second order in the rotation of the body, and pieces are short enough for them to be small.
class CarriedTool {
 public:
  explicit CarriedTool(ToolPath& path) : path_(path), parts_(path.parts), memory_(path.parts.memory) {}
  PieceEnd run();

 private:
  double largestShare(const BodyMotion& left) const;
  PieceEnd arrive(const BodyMotion& left);
  bool push(const BodyMotion& left, double share);
  void advance(double share, const Displacement& step, const Configuration& to);

  ToolPath& path_;
  StepParts& parts_;
  StepMemory& memory_;
};

PieceEnd CarriedTool::run() {
  const double own_margin = path_.margin.value();
  PieceEnd end = PieceEnd::GoesOn;
  while (memory_.moving_count > 0) {
    if (!path_.mayGoOn()) return PieceEnd::Blocked;
    const BodyMotion left = motionLeft(memory_);
    if (path_.margin.widenForBodies(own_margin, left.length) && !path_.search()) {
      advanceBodies(1, memory_);
      memory_.sides_known = false;
      return PieceEnd::Blocked;
    }
    if (path_.isFree()) {
      advance(std::min(1.0, path_.margin.left() / left.length), {}, path_.now());
      continue;
    }
    const double share = largestShare(left);
    end = share == 1 && path_.depth() <= path_.limits.depth && !parts_.rubsOrGives() ? arrive(left) : PieceEnd::Blocked;
    if (end == PieceEnd::Blocked && push(left, share)) end = PieceEnd::GoesOn;
    if (end == PieceEnd::Blocked) {
      parts_.result.faults |= kWorkLimit;
      return end;
    }
  }
  // A ball that is squeezed in by half may leave a skin on the other side: its side is determined again.
  if (path_.depth() > 0.5 * parts_.scene.min_contact) memory_.sides_known = false;
  return end;
}

// The share of the bodies' way for which the rows are accurate enough.
double CarriedTool::largestShare(const BodyMotion& left) const {
  const double share =
      std::min(path_.margin.shareOfBodies(left.length), std::sqrt(0.2 * path_.limits.depth / std::max(left.length * left.turn, 1e-12)));
  return path_.depth() > path_.limits.depth ? std::min(share, 0.25 * parts_.scene.min_contact / left.length) : share;
}

// If the bodies arrive in this piece, the tool goes on to the haptic pose at the same time: in the frame of an object
// its motion is the same as if it did so afterwards. If that does not fit in a piece, the tool waits: Blocked.
PieceEnd CarriedTool::arrive(const BodyMotion& left) {
  const QpAnswer& answer = memory_.answer;
  path_.carryRows(1);
  const Vector6 want = path_.scaledWay();
  const double back = path_.solveCarried(want);
  const Displacement step = parts_.displacement(answer.y);
  const double largest = std::min(path_.margin.left(), path_.margin.feltReach()) - left.length;
  if (back != 0 || answer.status != QpStatus::Optimal || parts_.reach(step) > largest || step.rotation.norm() > path_.limits.turn ||
      path_.limits.force.shareWithin(want, answer.y, 1) != 1) {
    path_.makeRows();
    return PieceEnd::Blocked;
  }
  parts_.keepActive(path_.pairs());
  const bool is_free = answer.active_count == 0;
  advance(1, step, is_free ? path_.haptic : moved(path_.now(), step));
  return is_free ? PieceEnd::AtRest : PieceEnd::GoesOn;
}

// The bodies move by this share of their way, or less, and push the tool. Returns false if it cannot get out of their
// way within a piece.
bool CarriedTool::push(const BodyMotion& left, double share) {
  for (int n = 0; n < kMaxShorter; ++n) {
    path_.carryRows(share);
    const Displacement step = path_.pushed(share);
    const double room = path_.margin.left() - share * left.length, way = parts_.reach(step), turn = step.rotation.norm(),
                 largest_turn = path_.limits.turn;
    if (way <= room && turn <= largest_turn) {
      advance(share, step, moved(path_.now(), step));
      return true;
    }
    share *= 0.5 * std::min({1.0, room / way, largest_turn / std::max(turn, 1e-12)});
    path_.makeRows();
  }
  return false;
}

// Advances the tool and the bodies to the end of a piece. The motion of bodies explains a change of the force, as the
// motion of the hand does.
void CarriedTool::advance(double share, const Displacement& step, const Configuration& to) {
  path_.margin.use(share * motionLeft(memory_).length + parts_.reach(step));
  for (const PairRun& run : path_.pairs().runs) {
    const MovingBody& body = memory_.bodies[memory_.objects[run.object].body];
    if (body.moves) path_.limits.force.allow(parts_.scaledVector(motionAt(body, share, path_.now().position)));
  }
  path_.moveTo(to);
  if (parts_.scene.has_soft && !path_.isFree()) parts_.giveWay(1);
  advanceBodies(share, memory_);
  if (!path_.isFree()) path_.makeRows();
  path_.answerNow();
}

}  // namespace

PieceEnd carryTool(ToolPath& path) { return CarriedTool(path).run(); }

}  // namespace spheretree::runtime
