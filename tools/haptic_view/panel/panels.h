// SPDX-License-Identifier: GPL-3.0-or-later
// Panels, plots, the time slider, labels in the scene, and the help.
#pragma once

#include "panel/viewer_state.h"

namespace spheretree::view {

/// Draws everything except the scenes themselves.
void drawPanels(ViewerState& state, const Layout& layout, double scale);

}  // namespace spheretree::view
