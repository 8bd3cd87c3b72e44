// SPDX-License-Identifier: GPL-3.0-or-later
// Where a scene needs accuracy: its regions of work, and the space that the tool can reach.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/batch/tree_figures.h"
#include "spheretree/builder/graded_tolerance.h"
#include "spheretree/builder/reachable_space.h"
#include "spheretree/core/sphere_tree.h"
#include "spheretree/formats/scene_file.h"

namespace spheretree::pipeline {

/// Shared by the objects of a scene; constant after `space` is set.
struct WorkRegions {
  std::vector<formats::WorkRegion> regions;
  std::optional<formats::Reach> reach;
  std::unique_ptr<const builder::ReachableSpace> space;  // if there is a `reach`; set before the first tree is built
  std::string key;                                       // everything on which tolerances depend, except the object's own mesh and pose
};

TriangleMesh inWorld(TriangleMesh mesh, const Configuration& pose);

/// Tolerances of the triangles of `world_mesh`, whose own tolerance is `tolerance_mm`; all tolerances are multiplied by
/// `scale`.
std::vector<double> tolerancesAt(const WorkRegions& work, const TriangleMesh& world_mesh, double tolerance_mm, double scale = 1);

/// One entry for each region that the object intersects. `mesh` is in the frame of the tree.
std::vector<WorkFigures> workFigures(const WorkRegions& work, const TriangleMesh& mesh, const Configuration& pose, const SphereTree& tree);

}  // namespace spheretree::pipeline
