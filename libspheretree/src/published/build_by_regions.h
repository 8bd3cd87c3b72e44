// SPDX-License-Identifier: GPL-3.0-or-later
// The framework that the published builders share. From the root down, breadth first: the medial axis is refined in the
// region of each node, a reducer covers the region with a few balls, they are refitted, redundant ones are dropped, and
// the region is divided among the rest, the children.
// Paper: G. Bradshaw, C. O'Sullivan. Adaptive medial-axis approximation for sphere-tree construction. ACM Trans.
//         Graphics 23(1), 2004; G. Bradshaw. Bounding volume hierarchies for level-of-detail collision handling.
//         Thesis, Trinity College Dublin, 2002. Differences: docs/algorithms/published/build_by_regions.md
// Units: mm, frame of the mesh. Deterministic for any number of threads.
#pragma once

#include <span>

#include "base/ball.h"
#include "geometry/distance_field.h"
#include "published/region_reducer.h"
#include "spheretree/builder/build_settings.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// Covers one region with each of the methods, refits, drops redundant balls, and returns the set with the smallest
/// worst overhang; on ties that of the first method. `pools`: the medial balls for each method. Empty if no method
/// finds balls.
std::vector<FittedBall> reduceRegion(const Region& region, std::span<const Method> methods,
                                     std::span<const std::span<const FittedBall>> pools, Progress& progress);

/// Builds the tree of one method, or of several of which each node takes the best ("combined"). Level l has at most
/// branching^l balls. The balls of a level, with those above that have no children, contain all points of the surface
/// that the method samples; certification closes what lies between. With a tolerance, nodes that keep it have no
/// children. Of `settings`, reads levels, branching, quality, tolerance_mm, medial_axis and seed. The mesh must have
/// passed checkMesh.
/// @throws std::invalid_argument for no method, Cancelled.
LevelBalls buildByRegions(const TriangleMesh& mesh, const DistanceField& field, std::span<const Method> methods,
                          const BuildSettings& settings, Progress& progress);

}  // namespace spheretree::builder
