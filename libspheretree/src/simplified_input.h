// SPDX-License-Identifier: GPL-3.0-or-later
// The input of the search for balls: the mesh in its canonical pose, so that no search depends on the pose in the file,
// and with fewer triangles if it is finer than the spheres can follow. The statements about a tree are proven against
// the original mesh.
#pragma once

#include <memory>

#include "base/ball.h"
#include "geometry/distance_field.h"
#include "mesh/canonical_pose.h"
#include "mesh/simplify_mesh.h"
#include "spheretree/builder/build_settings.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

struct SimplifiedInput {
  Pose pose;
  TriangleMesh mesh;    // the mesh to cover, in the pose: its lengths, and all lengths of the search, are in units of pose.scale
  DistanceField field;  // of solid, sheets and, for tissue, an inner sheet; with the slack of a graded tree
  std::size_t simplified_triangles = 0;  // triangles of the simplified solid; 0: the search runs on the original mesh
  std::unique_ptr<MeshSimplifier>
      simplifier;  // of the solid, in the frame of the mesh [mm], to go on from there; none if it was not simplified
  double simplifier_distance_mm = kInfinity;  // proven: no point of the solid is farther than this from the surface of the simplifier [mm]
  double distance_bound_mm = 0;               // proven: no point of the original mesh is farther than this from the simplified surface [mm]
};

/// Made from the solid that `mesh` bounds, from `cover_too`, and from the `sheets` among it (surface_with_sheets.h).
/// The solid is simplified if it has far more triangles than the tree can follow, unless the tree is graded, the walls
/// are so thin that simplified ones would cross, or the tolerance is too small. `mesh` has to outlive the result.
/// @throws Cancelled.
SimplifiedInput simplifyInput(const TriangleMesh& mesh, const TriangleMesh& sheets, const TriangleMesh& cover_too,
                              const BuildSettings& settings, Progress& progress);

/// Transforms a result of the search from the pose to the frame of the mesh [mm].
LevelBalls inFrameOfMesh(LevelBalls balls, const Pose& pose);

}  // namespace spheretree::builder
