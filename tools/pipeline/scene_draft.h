// SPDX-License-Identifier: GPL-3.0-or-later
// Makes a scene from mesh files: every part becomes an object with a unique and safe name, and a tool is found or
// supplied. `spheretree scene` writes it, and `spheretree batch` uses it for mesh files. Units: mm. Rules:
// docs/scene_file.md
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/mesh_store.h"
#include "spheretree/formats/scene_file.h"

namespace spheretree::pipeline {

/// The tolerance of objects whose name matches `pattern` (shell style: *, ?, [abc]).
struct ToleranceMatch {
  std::string pattern;
  double tolerance_mm = 0;
};

struct SceneDraftSettings {
  std::vector<std::filesystem::path> files;  // meshes in any format of formats::readMesh, or trees (.stree)
  std::string tool = {};                     // the name of a part or object, or a file; "": found by its name, or a ball
  std::string unit = {};                     // of all files, including glTF; "": mm, for glTF m
  std::optional<double> tolerance_mm = {};   // of the tool, and of every object that matches no pattern
  std::vector<ToleranceMatch> matches = {};  // later patterns have precedence over earlier ones
  std::optional<double> reach_mm = {};       // radius of formats::Reach
  bool components = false;                   // each connected component becomes an object, in place of each part
  std::string frame = {};                    // "LPS" or "RAS": objects of files that state the other one are turned; "": none
};

struct SceneDraft {
  formats::SceneFile scene;          // paths relative to the folder of the scene
  std::vector<std::string> notes;    // what a user should check: sizes, new names, omissions; whole sentences
  std::filesystem::path ball;        // the tool if none was given: a file to write; empty: not needed
  std::vector<std::byte> ball_mesh;  // content of that file
};

/// `scene_path`: the future path of the scene; it need not exist, and nothing is written. `meshes` keeps the files that
/// were read, and the ball.
/// @throws tool::UsageError if there is no object, too many, no such tool, or a pattern without a match;
/// formats::FileError, formats::FormatError for the files.
SceneDraft draftScene(const SceneDraftSettings& settings, const std::filesystem::path& scene_path, MeshStore& meshes);

/// The pattern and the length of, for example, "tooth_*=0.1". @throws tool::UsageError
ToleranceMatch parseToleranceMatch(const std::string& text);

/// The OBJ of the ball that is the tool of a draft without one. draftScene() names it ball.obj, beside the scene,
/// unless a part has that name.
std::vector<std::byte> defaultToolFile();

}  // namespace spheretree::pipeline
