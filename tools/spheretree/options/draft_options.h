// SPDX-License-Identifier: GPL-3.0-or-later
// Options for making a scene from mesh files, for `scene` and for `batch` with mesh files.
#pragma once

#include <CLI/CLI.hpp>

#include "pipeline/scene_draft.h"

namespace spheretree::tool {

/// --tool, --match, --reach and --unit. The verb adds --tolerance itself.
void addDraftOptions(CLI::App& app, pipeline::SceneDraftSettings& draft);

}  // namespace spheretree::tool
