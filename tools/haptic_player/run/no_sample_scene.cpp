// SPDX-License-Identifier: GPL-3.0-or-later
// In place of sample_scene.cpp where the program was built without the builders.
#include "program_end.h"
#include "run/sample_scene.h"

namespace spheretree::player {

runtime::SceneDescription sampleScene(builder::Progress&) {
  throw tool::UsageError(
      "this haptic-player was built without the builders, so it has no built-in scene. Name a scene, as `spheretree batch` writes it");
}

}  // namespace spheretree::player
