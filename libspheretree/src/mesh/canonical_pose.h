// SPDX-License-Identifier: GPL-3.0-or-later
// A canonical pose and size for an object, since the result of a search must not depend on how the file has the object
// rotated, moved and scaled. Without it, rounding errors alone lead two searches to different results: on a tooth the
// worst overhang of a rotated copy differed by up to a fifth.
#pragma once

#include <Eigen/Core>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// A point p of the mesh is turn^T (p - centre) / scale in the pose.
struct Pose {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();  // a rotation; its columns are the axes of the pose
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();    // centroid of the surface [mm]
  double scale = 1;                                    // root mean square distance of the surface from the centroid [mm]

  Eigen::Vector3d toMesh(const Eigen::Vector3d& in_pose) const { return centre + scale * (turn * in_pose); }
};

/// Axes: the principal axes of the surface, the longest first, with their heavier tails on the positive side. Where
/// moments do not distinguish axes (cube, square plate, prism), the axes to which most normals are parallel are used.
/// Of the rotations that map a symmetric object onto itself, the one whose triangle list comes first in order is
/// chosen. Cost: O(triangles), with a symmetry O(n log n). The mesh must have area.
Pose canonicalPose(const TriangleMesh& mesh);

/// Largest distance by which rounding to the grid moves a point [scale].
inline constexpr double kPoseRounding = 0x1p-25;

/// The mesh in the pose, rounded to a grid of 2^-25. The grid is finer than the float32 of a tree, so that no accuracy
/// is lost, and coarse enough that it nearly always absorbs the rounding errors of a rotation. Rotated, moved or scaled
/// copies of a mesh then become equal bit for bit.
TriangleMesh inPose(const TriangleMesh& mesh, const Pose& pose);

}  // namespace spheretree::builder
