// SPDX-License-Identifier: GPL-3.0-or-later
// Names of teeth, and where the hand of a window begins: over a tooth. Units: mm.
#pragma once

#include <optional>

#include "model/stage.h"

namespace spheretree::player {

/// Fills in is_tooth, fdi and meaning from the name of the body: "tooth_46" is the lower right first molar.
void readTooth(view::Body& body);

/// A tooth, and the pose of a tool close to its crown.
struct StartOverTooth {
  Configuration pose;     // of the reference point
  Eigen::Vector3d crown;  // the highest point of the tooth
};

/// First molars come first. The tool is free of all objects, straight or inclined by 60 degrees. Empty if the scene has
/// no tooth, or no such pose.
std::optional<StartOverTooth> startOverTooth(const view::Stage& stage);

}  // namespace spheretree::player
