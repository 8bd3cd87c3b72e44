// SPDX-License-Identifier: GPL-3.0-or-later
// The poses of a scene's bodies at each time of a run.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "spheretree/formats/scene_file.h"
#include "spheretree/runtime/step.h"
#include "spheretree/scene/describe_scene.h"
#include "streams/recorded_step.h"

namespace spheretree::player {

class BodyPaths {
 public:
  BodyPaths() = default;
  /// @throws formats::FileError, formats::FormatError
  BodyPaths(const formats::SceneFile& file, const std::filesystem::path& scene_path);

  bool empty() const { return bodies_.empty(); }
  /// The first kMaxHinges bodies with a hinge, in the order of the scene.
  struct HingedBody {
    std::string name;
    double lowest = 0, highest = 0;  // range of the angles on its path [degree]
  };
  const std::vector<HingedBody>& hinged() const { return hinged_; }
  /// The angles at time `t` according to the scene.
  HingeAngles anglesAt(double t) const noexcept;
  /// The pose of a body; body 1 is the first one of the scene file, as scene::bodyNumber() counts them. After the end
  /// of a pose file its last pose is used. No allocation.
  Configuration at(std::size_t body, double t, const HingeAngles& angles) const noexcept;
  /// Before a step: sets the pose of every body at the end of the step. No allocation.
  void moveTo(double t, const HingeAngles& angles, runtime::Workspace& workspace) const noexcept;
  /// The poses of all bodies, body 1 first.
  std::vector<Configuration> posesAt(double t, const HingeAngles& angles) const;

 private:
  struct Path : scene::BodyPath {
    std::size_t number = kMaxHinges;  // index in hinged(); kMaxHinges: not in it
  };
  std::vector<Path> bodies_;
  std::vector<HingedBody> hinged_;
};

/// The paths of a scene file; empty for an empty path, that is the built-in sample. @throws formats::FileError,
/// formats::FormatError
BodyPaths readBodyPaths(const std::filesystem::path& scene);

}  // namespace spheretree::player
