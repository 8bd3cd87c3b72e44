// SPDX-License-Identifier: GPL-3.0-or-later
// Samples where a cover that looks whole on the samples so far leaves the mesh open: between them, at edges and corners
// above all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/ball.h"
#include "certify/certify_cover.h"
#include "geometry/box_tree.h"
#include "geometry/distance_field.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

class GapSampler {
 public:
  /// `spacing`: of the samples, about, as a share of the width that the patch of one of `balls` balls has.
  GapSampler(const TriangleMesh& mesh, const DistanceField& field, std::size_t balls, double spacing);

  /// Uncovered points of the mesh where the balls, each grown by `h`, leave holes deeper than `tolerance` times `h`;
  /// none if there are none. `left`: the balls that have moved or gone since the last call with the same `h`, as they
  /// were then: what is open now was held by one of those, or open then. Null: look everywhere.
  std::vector<Eigen::Vector3d> find(std::span<const Ball> balls, double h, double tolerance, const std::vector<Ball>* left,
                                    Progress& progress);

  std::size_t triangles() const { return all_.size(); }  // that find looks at, at most
  std::size_t lookedAt() const { return looked_at_; }    // of them, at the last call

 private:
  TriangleMesh mesh_;
  double spacing_;
  std::vector<std::uint32_t> all_;
  std::vector<HeldBy> held_by_;      // of each triangle
  std::vector<std::uint32_t> open_;  // triangles with gaps at the last call
  std::size_t looked_at_ = 0;
  BoxTree triangles_;
};

}  // namespace spheretree::builder
