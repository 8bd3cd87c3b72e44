// SPDX-License-Identifier: GPL-3.0-or-later
// Whether hulls cover every triangle of a mesh, with a proof: a triangle lies in a hull if its corners do, since a hull
// is convex; a triangle that lies in no single hull is halved. docs/algorithms/hulls/hull_cover.md
// Units: mm, frame of the mesh.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "certify/triangle_piece.h"
#include "geometry/box_tree.h"
#include "geometry/hull.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/none.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

class HullCover {
 public:
  /// A point counts as held if it is deeper than `margin` [mm] in a hull, which must exceed the errors of rounding.
  HullCover(std::span<const Hull> hulls, double margin);

  /// Whether the hulls, without number `omitted`, provably hold the triangle. False if a point of it lies in none, or
  /// if pieces as short as the margin still lie in no single one; `bare` then receives that point, or one of a piece.
  bool holds(const Piece& triangle, std::size_t omitted = kNone, Eigen::Vector3d* bare = nullptr) const;

 private:
  std::vector<HullDistance> distance_;  // in slot order
  BoxTree tree_;
  double margin_;
};

/// Whether the hulls, whose centres are relative to `origin`, provably cover the mesh. Deterministic for any number of
/// threads.
bool provenCovered(const TriangleMesh& mesh, std::span<const Hull> hulls, const Eigen::Vector3d& origin, Progress& progress);

}  // namespace spheretree::builder
