// SPDX-License-Identifier: GPL-3.0-or-later
// What the balls of a tree are searched on: the mesh in its canonical pose, so that no search depends on how a file has
// the object turned, and on fewer triangles where it has more than the spheres can follow. What a build states is
// proven against the mesh that was given.
#pragma once

#include "base/ball.h"
#include "geometry/distance_field.h"
#include "mesh/canonical_pose.h"
#include "spheretree/builder/build_settings.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

struct SimplifiedInput {
  Pose pose;
  TriangleMesh mesh;    // what is to be covered, in the pose: its lengths, and all of the search, are in units of pose.scale
  DistanceField field;  // of solid, sheets and, for tissue, an inner sheet; with the slack of a graded tree
  std::size_t simplified_triangles = 0;  // of the simplified solid; 0: the search runs on the mesh given
  double distance_bound_mm = 0;          // proven: no point of the mesh given is farther from the simplified surface [mm]
};

/// Of the solid that `mesh` bounds, of `cover_too`, and of the `sheets` among it (surface_with_sheets.h). The solid is
/// simplified if it has far more triangles than the tree can follow, unless the tree is graded, the walls are so thin
/// that the simplified ones cross, or the tolerance is too small for it. @throws Cancelled.
SimplifiedInput simplifyInput(const TriangleMesh& mesh, const TriangleMesh& sheets, const TriangleMesh& cover_too,
                              const BuildSettings& settings, Progress& progress);

/// What was found in the pose, in the frame of the mesh [mm].
LevelBalls inFrameOfMesh(LevelBalls balls, const Pose& pose);

}  // namespace spheretree::builder
