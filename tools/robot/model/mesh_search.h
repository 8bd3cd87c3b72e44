// SPDX-License-Identifier: GPL-3.0-or-later
// Finds the mesh files that a URDF names. Documentation: docs/robots.md
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace spheretree::robot {

/// Where packages are searched, before the folders above the URDF, ROS_PACKAGE_PATH and AMENT_PREFIX_PATH.
struct PackagePaths {
  std::vector<std::filesystem::path> folders;          // each is a package, or holds packages
  std::map<std::string, std::filesystem::path> named;  // the folder of a package
};

/// Each word is FOLDER or NAME=FOLDER. A word that is a folder is one, even if it contains "=".
/// @throws formats::FileError if there is no such folder.
PackagePaths packagePaths(const std::vector<std::string>& words);

/// The mesh files of one URDF.
class MeshSearch {
 public:
  MeshSearch(const std::filesystem::path& urdf, const PackagePaths& packages);

  /// `name` is `package://NAME/REST`, `model://NAME/REST`, `file://PATH` or a path relative to the URDF; `\` stands for
  /// `/`, and %20 for a blank, where only that names a file. A folder is the package NAME if it or its package.xml has
  /// this name. If no folder is, REST is searched in the folders above the URDF, likewise a path that is not relative
  /// to the URDF; a note then says which folder was taken.
  /// @throws formats::FileError, beginning with `place`
  std::filesystem::path find(const std::string& name, const std::string& place);

  /// Of find(), each package once.
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  std::filesystem::path findInPackage(const std::string& package, const std::filesystem::path& rest);
  const std::vector<std::filesystem::path>& foldersOf(const std::string& package);
  std::filesystem::path findAbove(const std::filesystem::path& rest, const std::string& taken_to_be, const std::string& advice,
                                  const std::string& place);

  std::filesystem::path folder_;  // of the URDF
  const PackagePaths& packages_;
  std::vector<std::filesystem::path> searched_;
  std::map<std::string, std::vector<std::filesystem::path>> folders_of_;  // folders that are a package
  std::set<std::string> noted_;
  std::vector<std::string> notes_;
};

}  // namespace spheretree::robot
