// SPDX-License-Identifier: Apache-2.0
// Handles a tool that starts inside an object. A skin keeps the tool on the side where it is, so the tool would be
// trapped inside. Leaves push it out: they cover the whole object, and a tool that touches none of them is outside.
#pragma once

namespace spheretree::runtime {

class StepParts;

/// Before the first step: for each object whose skin the graphic tool crosses or is within, the tool rests on the
/// leaves instead. A connected part of the tool that is not in a skin has one side, which is determined once. Costs
/// nothing in later steps.
void settleSides(StepParts& parts);

/// After a step: objects that the graphic tool has left use their skins again. Costs nothing unless leaves replace a
/// skin.
void leaveInsides(StepParts& parts);

}  // namespace spheretree::runtime
