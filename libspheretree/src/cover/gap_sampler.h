// SPDX-License-Identifier: GPL-3.0-or-later
// Samples in the gaps of a cover that is complete on the samples so far: gaps lie between samples, and mostly at edges
// and corners.
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
  /// `spacing`: approximate distance of the samples, as a share of the width of a patch, if `balls` balls divide the
  /// surface.
  GapSampler(const TriangleMesh& mesh, const DistanceField& field, std::size_t balls, double spacing);

  /// Uncovered points of the mesh where the balls, each grown by `h`, leave gaps deeper than `tolerance` times `h`;
  /// empty if there are no such gaps. `left`: the balls that have been moved or removed since the last call with the
  /// same `h`, in their state at that call. A point that is uncovered now was in one of these balls, or was already
  /// uncovered then, so only those places are searched. Null: the whole mesh is searched.
  std::vector<Eigen::Vector3d> find(std::span<const Ball> balls, double h, double tolerance, const std::vector<Ball>* left,
                                    Progress& progress);

  std::size_t triangles() const { return all_.size(); }  // largest number that find() can test
  std::size_t lookedAt() const { return looked_at_; }    // number that the last call tested

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
