// SPDX-License-Identifier: Apache-2.0
// How the surface of soft tissue answers forces, by the compliance matrix of the surface (core's TissueResponse): to
// predict displacements near points of contact, without changing the surface.
//
// A force on a point of a triangle of the skin is distributed to the corners of the triangle, and from there to the
// nodes with which they move. Displacements are computed for the nodes that move near points.
// Units: mm, N; frame: axes of the object. No allocation after construction.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "tissue/soft_model.h"

namespace spheretree::runtime {

class SurfaceResponse {
 public:
  /// A force on a point, distributed to pressed nodes.
  struct Press {
    std::array<std::uint32_t, 9> node;
    std::array<double, 9> weight;
    std::size_t count = 0;
  };

  explicit SurfaceResponse(const SoftModel& model);

  /// The vertices of a triangle of the skin.
  const std::array<std::uint32_t, 3>& corners(std::uint32_t triangle) const { return corners_[triangle]; }
  Press pressOn(const SkinPoint& point) const;

  void forgetNear();
  void addNear(std::uint32_t triangle);
  std::size_t nearCount() const { return near_.size(); }
  /// The displacement of each near node under a unit force on a point: by columns, along each axis of the force. Cost:
  /// about 0.1 us for each pressed node of the point, and for each ten near nodes.
  void respond(const Press& press, std::span<Eigen::Matrix3d> near) const;
  /// The weighted mean of a field (near node: x, y, z) over the nodes of `of`.
  Eigen::Vector3d meanOf(const Press& of, std::span<const double> near) const;
  /// Sets the field that predicted() evaluates.
  void predict(std::span<const double> near);
  Eigen::Vector3d predicted(const SkinPoint& point) const;

 private:
  const SoftModel& model_;
  std::vector<std::array<std::uint32_t, 3>> corners_;  // (triangle) its vertices
  std::vector<std::uint32_t> near_, near_at_;          // near pressed nodes; (pressed node) its index among them, or ~0u
  std::vector<std::uint32_t> near_vertices_;
  std::vector<char> is_near_;               // (vertex)
  std::vector<Eigen::Vector3f> predicted_;  // (vertex)
};

}  // namespace spheretree::runtime
