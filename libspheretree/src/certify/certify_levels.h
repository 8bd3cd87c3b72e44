// SPDX-License-Identifier: GPL-3.0-or-later
// Turns the balls of each level into stored spheres, with a proof for every level that it covers the mesh by itself.
#pragma once

#include <limits>
#include <vector>

#include "base/ball.h"
#include "geometry/distance_field.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/sphere.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// What levels are certified against. The referenced objects must outlive the call.
struct CertificationTarget {
  const TriangleMesh& mesh;    // every triangle has to be covered
  const DistanceField& field;  // overhang is measured in it; for a graded tree, the field with slack
  Eigen::Vector3d origin;      // stored centres are relative to it [mm]
  std::uint64_t seed = 1;      // of the samples that find redundant spheres
};

/// A level, together with the leaves of earlier levels, covers the mesh.
struct CertifiedLevels {
  std::vector<std::vector<Sphere>> spheres;                         // (levels)(spheres)
  std::vector<std::vector<std::uint32_t>> parents;                  // as in LevelBalls
  std::vector<double> largest_growth;                               // (levels) largest increase of a radius by certification [mm]
  std::size_t pieces = 0;                                           // pieces of triangles in the proofs
  double uncertified_overhang = 0;                                  // of the deepest level, before certification [mm]
  double overhang_bound = std::numeric_limits<double>::infinity();  // of the deepest level, proven [mm]

  LevelBalls uncertified;  // of a published method: the levels as they were given

  std::size_t count() const;  // spheres of all levels
};

/// Certifies each level, root first. A ball without a child on the next level is a leaf: it belongs to the cover of
/// every deeper level too, as one sphere whose radius is large enough for all of them. On the deepest level redundant
/// spheres are removed, except the last child of a sphere. Deterministic for any number of threads.
/// @throws Cancelled; std::invalid_argument as certifyCover().
CertifiedLevels certifyLevels(const CertificationTarget& target, const LevelBalls& levels, Progress& progress);

}  // namespace spheretree::builder
