// SPDX-License-Identifier: GPL-3.0-or-later
// Where in a scene accuracy is needed: its regions of work, and where the tool can come.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "spheretree/builder/graded_tolerance.h"
#include "spheretree/builder/reachable_space.h"
#include "spheretree/core/sphere_tree.h"
#include "spheretree/formats/scene_file.h"

namespace spheretree::tool {

/// Shared by the objects of a scene; constant once `space` is set.
struct WorkSite {
  std::vector<formats::WorkRegion> regions;
  std::optional<formats::Reach> reach;
  std::unique_ptr<const builder::ReachableSpace> space;  // with `reach`, before the first tree is built
  std::string key;                                       // all that tolerances depend on, but for the object's own mesh and pose
};

TriangleMesh inWorld(TriangleMesh mesh, const Configuration& pose);

/// Tolerances of the triangles of `world_mesh`, whose own is `tolerance_mm`; all that the scene says taken `scale` times.
std::vector<double> tolerancesAt(const WorkSite& site, const TriangleMesh& world_mesh, double tolerance_mm, double scale = 1);

/// For each region that the object reaches into: `name`, `tolerance_mm`, `triangles` in it, and `overhang_bound_mm`: no leaf reaches
/// farther out of the object through these triangles; proven. `mesh` in the frame of the tree.
nlohmann::ordered_json workFigures(const WorkSite& site, const TriangleMesh& mesh, const Configuration& pose, const SphereTree& tree);

}  // namespace spheretree::tool
