// SPDX-License-Identifier: Apache-2.0
// The pieces of a constrained step in which bodies move and push the tool ahead.
// Steps: docs/algorithms/runtime/moving_bodies.md
#pragma once

#include "step/tool_path.h"

namespace spheretree::runtime {

/// Moves the bodies to their targets; before the last piece the tool only moves where they push it. Returns GoesOn once
/// they have arrived, AtRest if the tool is then at the haptic pose, too, and Blocked if the step ends before they have
/// arrived.
PieceEnd carryTool(ToolPath& path);

}  // namespace spheretree::runtime
