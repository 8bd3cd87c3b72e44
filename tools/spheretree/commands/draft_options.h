// SPDX-License-Identifier: GPL-3.0-or-later
// Options that say how mesh files become a scene: those of `scene`, and of `batch` where it takes mesh files.
#pragma once

#include <CLI/CLI.hpp>

#include "pipeline/scene_draft.h"

namespace spheretree::tool {

/// --tool, --match, --reach and --unit. --tolerance is left to the verb.
void addDraftOptions(CLI::App& app, pipeline::SceneDraftSettings& draft);

}  // namespace spheretree::tool
