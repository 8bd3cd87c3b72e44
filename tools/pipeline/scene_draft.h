// SPDX-License-Identifier: GPL-3.0-or-later
// A scene from mesh files: every part an object, names made unique and safe, a tool found or supplied. What `spheretree
// scene` writes and `spheretree batch` does with mesh files. Units: mm. Rules: docs/scene_file.md
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/batch/mesh_store.h"
#include "spheretree/formats/scene_file.h"

namespace spheretree::pipeline {

/// Objects whose name matches `pattern` (shell style: *, ?, [abc]) get this tolerance.
struct ToleranceMatch {
  std::string pattern;
  double tolerance_mm = 0;
};

struct SceneDraftSettings {
  std::vector<std::filesystem::path> files;  // meshes in any format of formats::readMesh, or trees (.stree)
  std::string tool = {};                     // the name of a part or object, or a file; "": by its name, or a ball
  std::string unit = {};                     // of all files, glTF included; "": mm, glTF m
  std::optional<double> tolerance_mm = {};   // of every object that no pattern matches, and of the tool
  std::vector<ToleranceMatch> matches = {};  // a later one goes before an earlier one
  std::optional<double> reach_mm = {};       // radius of formats::Reach
};

struct SceneDraft {
  formats::SceneFile scene;          // paths relative to the folder of the scene
  std::vector<std::string> notes;    // what a user should look at: sizes, new names, what was left out; whole sentences
  std::filesystem::path ball;        // the tool where none was given: a file to write; empty: none is needed
  std::vector<std::byte> ball_mesh;  // what to write there
};

/// `scene_path`: where the scene will stand; it need not exist, nothing is written. `meshes` keeps the files that were
/// read, and the ball.
/// @throws tool::UsageError if there is no object, too many, no such tool, or a pattern without a match;
/// formats::FileError, formats::FormatError for the files.
SceneDraft draftScene(const SceneDraftSettings& settings, const std::filesystem::path& scene_path, MeshStore& meshes);

/// The pattern and the length of "tooth_*=0.1". @throws tool::UsageError
ToleranceMatch parseToleranceMatch(const std::string& text);

}  // namespace spheretree::pipeline
