// SPDX-License-Identifier: GPL-3.0-or-later
// Stores finished trees under the hash of everything that they depend on, so that an unchanged object is not built
// again.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/batch/tree_job.h"

namespace spheretree::pipeline {

/// Trees and figures in DIR/KEY.stree and DIR/KEY.json. An entry is valid only if both files are complete and belong
/// together.
class TreeCache {
 public:
  explicit TreeCache(std::filesystem::path folder) : folder_(std::move(folder)) {}
  std::optional<TreeResult> find(const std::string& key) const;
  /// Creates the folder, for as long as the tool::RunFiles of the caller. Call it before store(), and before work that
  /// would be lost if the folder is not writable.
  /// @throws formats::FileError if the folder is not writable.
  void prepare() const;
  /// @throws formats::FileError
  void store(const std::string& key, const TreeResult& result) const;
  /// The checked bytes of a soft tree (core's tissue_codec.h) from DIR/KEY.soft; empty if there is none.
  std::vector<std::byte> findSoft(const std::string& key) const;
  /// @throws formats::FileError
  void storeSoft(const std::string& key, const std::vector<std::byte>& bytes) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace spheretree::pipeline
