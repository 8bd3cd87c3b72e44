// SPDX-License-Identifier: GPL-3.0-or-later
// The stage that a view shows for a scene: its trees, and the meshes that the scene file names beside them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "model/stage.h"
#include "spheretree/runtime/scene.h"

namespace spheretree::player {

/// `path`: of the scene file; empty: the built-in sample. A mesh that cannot be read is left out with a note, since it
/// is only for display.
view::Stage stageOf(const runtime::SceneDescription& scene, const std::filesystem::path& path, std::vector<std::string>& notes);

/// The meshes of the built-in sample: tool, then objects.
std::vector<TriangleMesh> sampleMeshes();

}  // namespace spheretree::player
