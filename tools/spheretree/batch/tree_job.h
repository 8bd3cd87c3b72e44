// SPDX-License-Identifier: GPL-3.0-or-later
// One tree of a batch: where its mesh comes from, how it is built, and the result with its figures, kept in a cache by content.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "batch/work_site.h"
#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/builder/repair_mesh.h"
#include "spheretree/formats/mesh_file.h"
#include "spheretree/formats/scene_file.h"

namespace spheretree::tool {

using Json = nlohmann::ordered_json;

/// Mesh files of a scene, each read once however many of its parts are objects. Safe for any number of threads.
class MeshStore {
 public:
  struct File {
    formats::MeshFile mesh;
    Hash128 hash;  // of what the file says: its bytes, or for glTF with files of its own the mesh
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

struct TreeResult {
  SphereTree tree;
  Json record;  // figures for the report, and nothing that depends on clock or machine
  double seconds = 0;
};

struct TreeJob {
  std::shared_ptr<const MeshStore::File> file;
  std::filesystem::path path;  // for messages
  std::string part;            // "": all
  std::string repair = "auto";
  builder::BuildSettings settings;
  Configuration pose;                    // of an object in the world
  std::shared_ptr<const WorkSite> site;  // null: the same accuracy everywhere
  // With settings.most_leaves > 0: all of them are used, and the tolerance says where: the scene's tolerances times `scale`, as near as
  // these leaves come to them.
  double scale = 1;

  /// Of all that the tree depends on: content, part, unit, settings and version of the program; 32 hexadecimal digits.
  std::string key() const;
  /// Of the mesh alone as it is built; 32 hexadecimal digits.
  std::string meshKey() const;
  /// The mesh as it is built, with a sentence for each change.
  builder::RepairedMesh solid(std::vector<std::string>& steps, builder::Progress& progress) const;
  TreeResult run(builder::Progress& progress) const;
};

/// Names from a scene file, which has checked them.
builder::BuildSettings buildSettings(const formats::TreeSettings& settings);

/// Trees and records under DIR/KEY.stree and KEY.json. An entry counts only if both are whole and belong together.
class TreeCache {
 public:
  explicit TreeCache(std::filesystem::path folder) : folder_(std::move(folder)) {}
  std::optional<TreeResult> find(const std::string& key) const;
  /// Makes the folder. Before store(), and before work that would be lost without. @throws formats::FileError if it cannot be written to.
  void prepare() const;
  void store(const std::string& key, const TreeResult& result) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace spheretree::tool
