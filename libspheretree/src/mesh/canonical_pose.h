// SPDX-License-Identifier: GPL-3.0-or-later
// One pose and size for an object, however its file has it turned, moved and scaled: what a search finds must not
// depend on that. Without it rounding alone makes two searches part: on a tooth the worst overhang of a turned copy
// differed by up to a fifth.
#pragma once

#include <Eigen/Core>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// A point p of the mesh is turn^T (p - centre) / scale in the pose.
struct Pose {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();  // a rotation; its columns are the axes of the pose
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();    // centroid of the surface [mm]
  double scale = 1;                                    // root mean square distance of the surface from it [mm]

  Eigen::Vector3d toMesh(const Eigen::Vector3d& in_pose) const { return centre + scale * (turn * in_pose); }
};

/// Axes: the principal axes of the surface, the longest first, with their heavier tails on the positive side. Where
/// moments do not tell axes apart (cube, square plate, prism) those that the normals keep to are taken; of the ways to
/// turn a symmetric object onto itself, the one in which its triangles come first. Cost: O(triangles), with a symmetry
/// O(n log n). The mesh must have area.
Pose canonicalPose(const TriangleMesh& mesh);

/// How far rounding to the grid moves a point, at most [scale].
inline constexpr double kPoseRounding = 0x1p-25;

/// The mesh in the pose, rounded to a grid of 2^-25: finer than the float32 of a tree, so that nothing is lost, and
/// coarse enough that the rounding of a turn hardly ever shows. Copies of a mesh that are turned, moved or scaled come
/// out equal to the bit.
TriangleMesh inPose(const TriangleMesh& mesh, const Pose& pose);

}  // namespace spheretree::builder
