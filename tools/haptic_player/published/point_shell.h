// SPDX-License-Identifier: GPL-3.0-or-later
// The surface of a tool as points with normals, in a hierarchy of balls.
// Paper: W. A. McNeely, K. D. Puterbaugh, J. J. Troy. Six degree-of-freedom haptic rendering using voxel sampling.
// SIGGRAPH 1999 (point shell); the hierarchy after J. Barbic, D. L. James, IEEE Transactions on Haptics 1(1), 2008.
// Units: mm.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "bodies/scenario_shapes.h"
#include "published/ball_tree.h"
#include "published/distance_grid.h"
#include "published/renderer.h"

namespace spheretree::player {

struct PointShell {
  static constexpr std::size_t kBytes = 32;  // of a point: position and normal in float, and its share of the hierarchy

  /// `count` points spread evenly over the surface of the tool, relative to its reference point.
  PointShell(const Body& tool, const Eigen::Vector3d& reference_point, std::size_t count);

  std::vector<Eigen::Vector3d> point, normal;  // normals outward, unit length
  BallTree tree;
};

/// A tool of points and a distance field of each object. A quarter of the memory of `scene` is used for the points, 200
/// to 20,000 of them, and the rest for the fields.
struct PointModel {
  explicit PointModel(const RendererScene& scene);

  PointShell shell;
  std::vector<DistanceGrid> grids;
};

}  // namespace spheretree::player
