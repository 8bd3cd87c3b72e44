// SPDX-License-Identifier: Apache-2.0
// From a scene file whose items are trees to the description that the runtime compiles, and to the paths of its bodies.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "spheretree/formats/scene_file.h"
#include "spheretree/runtime/scene.h"

namespace spheretree::scene {

/// A tree for objects of a scene.
struct LoadedTree {
  runtime::SharedTree tree;
  std::shared_ptr<const runtime::TissueModel> tissue = nullptr;  // of a .soft file
};

/// From the bytes of a .stree or a .soft file; `name` is the prefix of messages. @throws formats::FormatError
LoadedTree parseTree(std::span<const std::byte> bytes, const std::string& name);

/// `path`; of a folder: its scene.json, if there is one.
std::filesystem::path sceneFileAt(const std::filesystem::path& path);

/// Tool, objects with friction, stiffness, tissue and the bodies that move them, coupling and limits of `file`, which
/// was read from `path`. Items of one tree, or of files with the same bytes, share it. `on_tree(share)`, which may be
/// empty, is called before each tree is read, with the share of trees read by then; its exceptions end the work.
/// @throws formats::FileError; formats::FormatError for a scene of meshes, which `spheretree batch` turns into trees.
runtime::SceneDescription describeScene(const formats::SceneFile& file, const std::filesystem::path& path,
                                        const std::function<void(double)>& on_tree = {});

/// The number of a body of the scene file, counted from 1 as in the runtime; 0, the world, for any other name.
std::uint32_t bodyNumber(const formats::SceneFile& scene, const std::string& name);

/// The path of a body: the poses of a file, or a rotation about a hinge.
struct BodyPath {
  std::vector<Configuration> poses;  // one for each ms; empty: the hinge is used
  formats::Hinge hinge;
  /// The pose at time `t` [s]: after the end of the poses, the last one. No allocation.
  Configuration at(double t) const noexcept;
};

/// The paths of the bodies of `file`, which was read from `path`, in their order. @throws formats::FileError,
/// formats::FormatError
std::vector<BodyPath> readBodyPaths(const formats::SceneFile& file, const std::filesystem::path& path);

}  // namespace spheretree::scene
