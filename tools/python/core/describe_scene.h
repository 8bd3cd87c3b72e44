// SPDX-License-Identifier: Apache-2.0
// A scene file whose items are trees, as a description that the runtime compiles.
#pragma once

#include <filesystem>

#include "spheretree/runtime/scene.h"

namespace spheretree::python {

/// @throws formats::FileError; formats::FormatError for a scene of meshes, which `spheretree batch` turns into trees.
runtime::SceneDescription describeScene(const std::filesystem::path& path);

}  // namespace spheretree::python
