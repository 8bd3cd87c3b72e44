// SPDX-License-Identifier: GPL-3.0-or-later
// Where a scene needs accuracy: its regions of work, and the space that the tool can reach.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <span>
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
  std::string reach_key;                                 // the reach, and everything that may be in its way; "" without one
};

TriangleMesh inWorld(TriangleMesh mesh, const Configuration& pose);

/// Distance of a region from a box; 0 or less: they touch [mm].
double distanceOf(const formats::WorkRegion& region, const Eigen::AlignedBox3d& world_box);

/// The regions that can change a tolerance of an object with this bounding box and tolerance, if all tolerances are
/// multiplied by `scale`.
std::vector<formats::WorkRegion> regionsInRange(const WorkRegions& work, const Eigen::AlignedBox3d& world_box, double tolerance_mm,
                                                double scale);

/// Tolerances of the triangles of `world_mesh`, whose own tolerance is `tolerance_mm`, with these regions and the reach
/// of `work`; all tolerances are multiplied by `scale`.
std::vector<double> tolerancesAt(const WorkRegions& work, std::span<const formats::WorkRegion> regions, const TriangleMesh& world_mesh,
                                 double tolerance_mm, double scale = 1);

/// One entry for each of `regions` that the object intersects. `mesh` is in the frame of the tree.
std::vector<WorkFigures> workFigures(std::span<const formats::WorkRegion> regions, const TriangleMesh& mesh, const Configuration& pose,
                                     const SphereTree& tree);

}  // namespace spheretree::pipeline
