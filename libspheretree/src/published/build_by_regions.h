// SPDX-License-Identifier: GPL-3.0-or-later
// The framework that the published builders share: from the root down, breadth first, each node's region of the surface
// is covered by a few balls, which divide it among them; then the whole level is evened out.
// Paper: G. Bradshaw, C. O'Sullivan. Adaptive medial-axis approximation for sphere-tree construction. ACM Trans.
//         Graphics 23(1), 2004; G. Bradshaw. Bounding volume hierarchies for level-of-detail collision handling.
//         Thesis,
//         Trinity College Dublin, 2002. Differences: docs/algorithms/published/build_by_regions.md
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

struct PublishedSettings {
  int levels = 4;     // range [2, 6]; the root is level 0
  int branching = 8;  // range [2, 8]
  Quality quality = Quality::Standard;
  double tolerance_mm = 0;  // > 0: only as many levels, and balls on them, as the deepest level needs to keep this overhang
  std::uint64_t seed = 1;
};

/// @throws std::invalid_argument; the message names the setting out of range.
void checkSettings(const PublishedSettings& settings);

struct Method {
  Reducer reduce = nullptr;
  bool uses_medial_axis = true;  // false: its regions have an empty pool
};

/// Builds the balls of each level with one method, or with several. With several, each level is that of the method with
/// the smallest worst overhang (with a tolerance, the tree with the fewest balls); on ties, of the first such method.
/// All methods share the distance field and the points. The balls cover the surface except for gaps far smaller than
/// their overhang, which certifyCover() closes. There are no parents: each level is evened out as a whole, and
/// hierarchy.h groups them. A level has at most branching^level balls. There may be fewer levels than the settings
/// allow, if fewer keep the tolerance. The mesh must have passed checkMesh.
/// @throws std::invalid_argument for settings out of range or no method, Cancelled.
LevelBalls buildByRegions(const TriangleMesh& mesh, const DistanceField& field, std::span<const Method> methods,
                          const PublishedSettings& settings, Progress& progress);

}  // namespace spheretree::builder
