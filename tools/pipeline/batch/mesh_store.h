// SPDX-License-Identifier: GPL-3.0-or-later
// The mesh files of a scene, each read once however many of its parts are objects.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "spheretree/core/sphere_tree.h"
#include "spheretree/formats/mesh_file.h"

namespace spheretree::pipeline {

/// Safe for any number of threads.
class MeshStore {
 public:
  struct File {
    formats::MeshFile mesh;
    Hash128 hash;  // of what the file says: its bytes, or for glTF, which may refer to other files, the mesh
  };
  /// @throws what formats::readMesh throws; the same again for the same file.
  std::shared_ptr<const File> read(const std::filesystem::path& path, double unit_mm);

 private:
  struct Entry {
    std::mutex reading;
    std::shared_ptr<const File> file;
  };
  std::mutex mutex_;
  std::map<std::pair<std::filesystem::path, double>, std::unique_ptr<Entry>> entries_;
};

}  // namespace spheretree::pipeline
