// SPDX-License-Identifier: GPL-3.0-or-later
// The mesh files of a scene, each read once however many of its parts are objects.
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
    Hash128 hash;  // of what the file says: its bytes, or for glTF, which may refer to other files, the mesh
    Components components;
  };
  /// @throws what formats::readMesh throws; the same again for the same file.
  std::shared_ptr<const File> read(const std::filesystem::path& path, double unit_mm, double gltf_unit_mm);
  /// Of an item of a scene: in its own unit, whatever the format says, or else in that of the scene (glTF: m).
  std::shared_ptr<const File> read(const formats::SceneFile& scene, const std::filesystem::path& scene_path,
                                   const formats::SceneItem& item);
  /// A file that will only be written later: read() finds `mesh`, whose file holds `bytes`, under this path and unit.
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
