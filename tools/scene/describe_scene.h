// SPDX-License-Identifier: Apache-2.0
// From a scene file whose items are trees to the description that the runtime compiles, for the player and for Python.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "spheretree/formats/scene_file.h"
#include "spheretree/runtime/scene.h"

namespace spheretree::scene {

/// Tool, objects with friction, stiffness, tissue and the bodies that move them, coupling and limits of `file`, which
/// was read from `path`. Items of one tree, or of files with the same bytes, share it. `on_tree(share)`, which may be
/// empty, is called before each tree is read, with the share of trees read by then; its exceptions end the work.
/// @throws formats::FileError; formats::FormatError for a scene of meshes, which `spheretree batch` turns into trees.
runtime::SceneDescription describeScene(const formats::SceneFile& file, const std::filesystem::path& path,
                                        const std::function<void(double)>& on_tree = {});

/// The number of a body of the scene file, counted from 1 as in the runtime; 0, the world, for any other name.
std::uint32_t bodyNumber(const formats::SceneFile& scene, const std::string& name);

}  // namespace spheretree::scene
