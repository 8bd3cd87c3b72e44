// SPDX-License-Identifier: Apache-2.0
// Mode constrained: a step is a sequence of pieces. Guarantees: docs/runtime.md
#include <algorithm>

#include "step/approach.h"
#include "step/carry_tool.h"
#include "step/inside.h"
#include "step/note_contacts.h"

namespace spheretree::runtime {
namespace {

class ConstrainedStep {
 public:
  ConstrainedStep(StepParts& parts, const Configuration& haptic)
      : path_(parts, haptic), parts_(parts), memory_(parts.memory), result_(parts.result) {}
  void run();

 private:
  PieceEnd approach();
  bool pushOut();
  bool isPressedIn() const;
  void takeBack();
  void noteContacts(bool is_at_rest);

  ToolPath path_;
  StepParts& parts_;
  StepMemory& memory_;
  StepResult& result_;
};

void ConstrainedStep::run() {
  const bool has_carried = memory_.moving_count > 0;
  if (memory_.tissue) memory_.give_before = memory_.give;
  PieceEnd end = has_carried ? carryTool(path_) : PieceEnd::GoesOn;
  if (!isLast(end)) end = approach();
  memory_.is_behind = !hasArrived(end);
  const bool is_at_rest = !pushOut() && end == PieceEnd::AtRest;
  if (path_.best().isKnown()) {
    // Tissue is where the last piece left it.
    memory_.graphic = memory_.tissue ? path_.now() : path_.best().pose;
    result_.penetration = memory_.tissue ? path_.depth() : path_.best().depth;
  }
  if (memory_.tissue && !has_carried && isPressedIn()) takeBack();
  if (result_.penetration > kGapTolerance) result_.faults |= kPenetrating;
  noteContacts(is_at_rest);
  // The way out of an object is not a motion that inertia continues.
  if (parts_.scene.inertia.translation + parts_.scene.inertia.rotation > 0)
    memory_.motion = path_.wasInside() ? Displacement() : displacementBetween(path_.start, memory_.graphic);
}

// Piece by piece towards the haptic pose. Returns the end of the last piece.
PieceEnd ConstrainedStep::approach() {
  Approach approach(path_);
  PieceEnd end = PieceEnd::GoesOn;
  while (!isLast(end)) {
    const bool is_blocked = !path_.mayGoOn() || (path_.margin.needsSearch() && !path_.search());
    end = is_blocked ? PieceEnd::Blocked : approach.next().end;
  }
  if (end != PieceEnd::AtRest && end != PieceEnd::AtHand) path_.returnToNearest();
  return end;
}

// A piece with a rotation may end slightly inside. Moves straight out, if that works; otherwise the result is the last
// free pose. Returns whether it was tried.
bool ConstrainedStep::pushOut() {
  bool is_tried = false;
  for (int attempt = 0; attempt < 2; ++attempt) {
    const double deepest = std::max(path_.depth(), path_.feltDepth());
    if (!path_.knowsContacts() || deepest <= 0.5 * kGapTolerance || path_.depth() > path_.limits.depth) break;
    is_tried = true;
    const Displacement step = path_.pushed(0);
    path_.margin.use(parts_.reach(step));
    if (path_.margin.left() < 0) break;
    if (parts_.scene.has_soft) parts_.giveWay(1);
    path_.moveTo(moved(path_.now(), step));
    path_.makeRows();
    path_.record();
  }
  return is_tried;
}

// Whether tissue has moved into the tool, which had not the time to give way; or may have done so, as there was not the
// time to search.
bool ConstrainedStep::isPressedIn() const {
  if (!path_.best().isKnown()) return memory_.graphic.position == path_.start.position;
  return path_.depth() > std::max(path_.limits.depth, memory_.depth);
}

// Tool and tissue stay where the last step left them. In the next step, tissue that approaches a state of its solver
// waits, so that the tool can move away first.
void ConstrainedStep::takeBack() {
  memory_.tissue->takeBack();
  memory_.give = memory_.give_before;
  memory_.graphic = path_.start;
  memory_.is_behind = true;
  result_.penetration = memory_.depth;
  path_.dropAll();
}

// Stores the contacts that hold the graphic tool at its current pose. If the step ended for another reason than a QP
// whose solution was to stay, the QP is solved once more.
void ConstrainedStep::noteContacts(bool is_at_rest) {
  memory_.contact_count = 0;
  if (!path_.knowsContacts()) return;
  if (!is_at_rest) {
    path_.solve(path_.scaledWay());
    parts_.keepActive(path_.pairs());
  }
  runtime::noteContacts(path_.rows(), path_.start, parts_);
}

}  // namespace

void constrainedStep(StepParts& parts, const Configuration& haptic) {
  settleSides(parts);
  ConstrainedStep(parts, haptic).run();
  leaveInsides(parts);
}

}  // namespace spheretree::runtime
