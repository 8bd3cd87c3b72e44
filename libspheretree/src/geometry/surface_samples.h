// SPDX-License-Identifier: GPL-3.0-or-later
// Points on the surface that the builders measure with: spread evenly by area, and on the features that a cover must
// reach.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct SurfaceSample {
  Eigen::Vector3d point;   // [mm]
  Eigen::Vector3d normal;  // unit, outward: of the face, or the mean normal of the faces that meet at a feature
  std::uint32_t triangle;  // a triangle that contains the point
  bool feature;            // on a sharp edge or a corner
};

struct SampleSettings {
  std::size_t count = 20000;          // number of points on faces; features are added, at most half as many
  double sharp_angle = 0.5235987756;  // an edge is a feature if the normals of its faces differ by more than this [rad], 30 degrees
  std::uint64_t seed = 1;
};

/// Stratified by area: the cumulative area is divided into `count` equal shares and one point is drawn in each, so that
/// no patch of several shares is missed. Features: mesh corners where sharp edges meet or end, and points along sharp
/// edges at the mean spacing of the face samples. Deterministic. Cost: O(triangles log triangles + count).
std::vector<SurfaceSample> sampleSurface(const TriangleMesh& mesh, const SampleSettings& settings);

}  // namespace spheretree::builder
