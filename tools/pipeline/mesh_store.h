// SPDX-License-Identifier: GPL-3.0-or-later
// The mesh files of a scene. Each file is read once, even if several of its parts are objects.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <tuple>

#include "pipeline/part_choice.h"
#include "spheretree/core/sphere_tree.h"
#include "spheretree/formats/mesh_file.h"
#include "spheretree/formats/scene_file.h"

namespace spheretree::pipeline {

/// Safe for any number of threads.
class MeshStore {
 public:
  struct File {
    formats::MeshFile mesh;
    Hash128 hash;  // of the bytes of the file, or of the mesh for glTF, which may refer to other files
    Components components;
  };
  /// @throws the exceptions of formats::readMesh, in every call for the same file.
  std::shared_ptr<const File> read(const std::filesystem::path& path, double unit_mm, double gltf_unit_mm);
  /// The mesh of an item: in its own unit, which overrides that of the format, otherwise in the unit of the scene
  /// (glTF: m).
  std::shared_ptr<const File> read(const formats::SceneFile& scene, const std::filesystem::path& scene_path,
                                   const formats::SceneItem& item);
  /// Registers a file that will be written later: read() returns `mesh` for this path and unit; `bytes`: content of its
  /// file.
  void hold(const std::filesystem::path& path, double unit_mm, TriangleMesh mesh, std::span<const std::byte> bytes);

 private:
  struct Entry {
    std::mutex reading;
    std::shared_ptr<const File> file;
  };
  std::mutex mutex_;
  std::map<std::tuple<std::filesystem::path, double, double>, std::unique_ptr<Entry>> entries_;
};

}  // namespace spheretree::pipeline
