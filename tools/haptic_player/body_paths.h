// SPDX-License-Identifier: GPL-3.0-or-later
// Where the bodies of a scene are at each time of a run.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "spheretree/formats/scene_file.h"
#include "spheretree/runtime/step.h"
#include "streams/recorded_step.h"

namespace spheretree::player {

class BodyPaths {
 public:
  BodyPaths() = default;
  /// @throws formats::FileError, formats::FormatError
  BodyPaths(const formats::SceneFile& scene, const std::filesystem::path& scene_path);

  bool empty() const { return bodies_.empty(); }
  /// The first kMostHinges bodies that turn about one, in the order of the scene.
  struct HingedBody {
    std::string name;
    double lowest = 0, highest = 0;  // angles on its path [degree]
  };
  const std::vector<HingedBody>& hinged() const { return hinged_; }
  /// Their angles at `t`, as the scene says.
  HingeAngles anglesAt(double t) const noexcept;
  /// Body 1 is the first of the scene file, as scene::bodyNumber() counts them. The last pose of a file is held. No
  /// allocation.
  Configuration at(std::size_t body, double t, const HingeAngles& angles) const noexcept;
  /// Before a step: where every body is to be at its end. No allocation.
  void moveTo(double t, const HingeAngles& angles, runtime::Workspace& workspace) const noexcept;
  /// Of every body, body 1 first.
  std::vector<Configuration> posesAt(double t, const HingeAngles& angles) const;

 private:
  struct Path {
    std::vector<Configuration> poses;  // one each ms; empty: the hinge
    formats::Hinge hinge;
    std::size_t number = kMostHinges;  // in hinged(); kMostHinges: not there
  };
  std::vector<Path> bodies_;
  std::vector<HingedBody> hinged_;
};

/// Those of a scene file; none for an empty path, the built-in sample. @throws formats::FileError, formats::FormatError
BodyPaths readBodyPaths(const std::filesystem::path& scene);

}  // namespace spheretree::player
