// SPDX-License-Identifier: GPL-3.0-or-later
// What a recorded run has cut: the path of the burr in the frame of each object, and the layers of its scene.
// Units: mm, s.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "cut/swept_burr.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/rigid.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::pipeline {

struct CutRun {
  struct Layer {
    std::string name;
    TriangleMesh mesh;  // sound, in the frame of the object
  };
  struct Object {
    std::string name;
    Configuration pose;         // in the world, at rest
    std::vector<Layer> layers;  // as in the scene
    std::vector<builder::BurrPath> paths;
  };
  std::filesystem::path scene;
  std::vector<Object> objects;     // that can be cut
  std::vector<std::string> notes;  // repairs of meshes
  std::size_t steps = 0, spinning = 0;
};

/// Reads the recording and the scene that it names. A step with spin 1 sweeps the capsule of each ball of the burr,
/// from the graphic tool of the row before to that of its own row; steps after `last_tick` are left out.
/// @throws formats::FileError, formats::FormatError: no column spin, a row that was lost, a tick beyond the recording,
/// a scene without burr or cut, builder::BuildError for a mesh that is not sound.
CutRun readCutRun(const std::filesystem::path& recording, std::uint64_t last_tick, builder::Progress& progress);

inline constexpr std::uint64_t kWholeRun = std::numeric_limits<std::uint64_t>::max();

}  // namespace spheretree::pipeline
