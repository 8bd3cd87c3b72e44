// SPDX-License-Identifier: GPL-3.0-or-later
// Balls of each level to stored spheres of each level, every level proven to cover the mesh by itself.
#pragma once

#include <limits>
#include <vector>

#include "base/ball.h"
#include "geometry/distance_field.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/sphere.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// What levels are certified against. The object must outlive the call.
struct CertificationTarget {
  const TriangleMesh& mesh;    // every triangle is to be covered
  const DistanceField& field;  // overhang is measured in it; of a graded tree, the field with slack
  Eigen::Vector3d origin;      // stored centres are relative to it [mm]
  std::uint64_t seed = 1;      // of the samples that find redundant spheres
};

/// A level together with the spheres that ended above it covers the mesh.
struct CertifiedLevels {
  std::vector<std::vector<Sphere>> spheres;                         // (levels)(spheres)
  std::vector<std::vector<std::uint32_t>> parents;                  // as in LevelBalls
  std::vector<double> largest_growth;                               // (levels) most that certification added to a radius [mm]
  std::size_t pieces = 0;                                           // pieces of triangles in the proofs
  double uncertified_overhang = 0;                                  // of the deepest level, before certification [mm]
  double overhang_bound = std::numeric_limits<double>::infinity();  // of the deepest level, proven [mm]

  std::size_t count() const;  // spheres of all levels
};

/// Certifies each level, root first. A ball without a child on the next level ends early: it belongs to the cover of
/// every deeper level too, as one sphere whose radius suits all of them. Of the deepest level, spheres that the others
/// make redundant are dropped, but never the last child of a sphere. Deterministic for any number of threads. @throws
/// Cancelled; std::invalid_argument as certifyCover().
CertifiedLevels certifyLevels(const CertificationTarget& target, const LevelBalls& levels, Progress& progress);

}  // namespace spheretree::builder
