// SPDX-License-Identifier: GPL-3.0-or-later
// The built-in scene: a dental probe over a molar, whose trees are built when it is asked for.
#pragma once

#include "spheretree/builder/progress.h"
#include "spheretree/runtime/scene.h"

namespace spheretree::player {

/// @throws builder::Cancelled; tool::UsageError where the program was built without the builders.
runtime::SceneDescription sampleScene(builder::Progress& progress);

}  // namespace spheretree::player
