// SPDX-License-Identifier: Apache-2.0
// A tool that starts inside an object. A skin keeps it on the side where it is, so it would be trapped there. Leaves
// push it out: they cover the whole object, and a tool that is free of them is outside.
#pragma once

namespace spheretree::runtime {

class StepParts;

/// Before the first step: the leaves are felt of each object whose skin the graphic tool crosses or is within. Cost:
/// nothing from then on.
void settleSides(StepParts& parts);

/// After a step: the skins are felt again of the objects that the graphic tool has left. Cost: nothing unless leaves
/// are felt in their place.
void leaveInsides(StepParts& parts);

}  // namespace spheretree::runtime
