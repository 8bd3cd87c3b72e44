// SPDX-License-Identifier: GPL-3.0-or-later
// The frame that the published builders share: from the root down, breadth first, each node's region of the surface is covered by a
// few balls, which divide it among them.
// Paper: G. Bradshaw, C. O'Sullivan. Adaptive medial-axis approximation for sphere-tree construction. ACM Trans. Graphics 23(1),
//        2004; G. Bradshaw. Bounding volume hierarchies for level-of-detail collision handling. Thesis, Trinity College Dublin,
//        2002. Where we depart from them: docs/algorithms/published_frame.md
// Units: mm, frame of the mesh. Deterministic for any number of threads.
#pragma once

#include <span>

#include "spheretree/builder/ball.h"
#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/builder/distance_field.h"
#include "spheretree/builder/progress.h"
#include "spheretree/builder/region_reducer.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct PublishedSettings {
  int levels = 4;     // range [2, 6]; the root is level 0
  int branching = 8;  // range [2, 8]
  Quality quality = Quality::Standard;
  double tolerance_mm = 0;  // > 0: a node whose ball reaches out no farther ends early, and children are as few as possible
  std::uint64_t seed = 1;
};

/// @throws std::invalid_argument that names the setting out of range.
void checkSettings(const PublishedSettings& settings);

struct Method {
  Reducer reduce = nullptr;
  bool uses_medial_axis = true;  // else its regions come with an empty pool
};

/// Builds the balls of each level with one method, or with several: then each node keeps the balls of the method whose worst
/// overhang is least, the first of equals. All members share the distance field, the points and the medial axis. The balls cover
/// the surface up to gaps far below their overhang, which certifyCover closes.
/// Fewer levels than asked for come back if every node ended early. The mesh must have passed checkMesh.
/// @throws std::invalid_argument for settings out of range or no method, Cancelled.
LevelBalls buildByRegions(const TriangleMesh& mesh, const DistanceField& field, std::span<const Method> methods,
                          const PublishedSettings& settings, Progress& progress);

}  // namespace spheretree::builder
