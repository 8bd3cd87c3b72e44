// SPDX-License-Identifier: GPL-3.0-or-later
// Where a ball can come that moves from outside through the space that solids leave free, and which triangles it may
// touch. Never wrong in the dangerous sense: a triangle that the ball can touch is called reached. One that it cannot
// may be called so, too, where the passage or the place is closer than the cell size to being reached.
// Units: mm, world frame. Deterministic for any number of threads.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

class ReachableSpace {
 public:
  /// `solids`: closed meshes, oriented outward; they may overlap. `radius` of the ball, > 0. The cells are half as wide
  /// as the radius, or a four-hundredth of the scene's diagonal if that is more.
  /// Cost: about one distance query for each cell near a surface; a mouth of 33 objects takes some seconds of processor
  /// time.
  /// @throws Cancelled, std::invalid_argument for no solids or a radius that is not positive.
  ReachableSpace(std::span<const TriangleMesh> solids, double radius, Progress& progress);

  /// One for each triangle of `mesh`: whether the ball may touch it.
  std::vector<char> reached(const TriangleMesh& mesh) const;

  double cell() const { return cell_; }

 private:
  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(cells_[1]) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(cells_[0]) +
           static_cast<std::size_t>(x);
  }
  Eigen::Vector3d centre(int x, int y, int z) const { return low_ + cell_ * (Eigen::Vector3d(x, y, z) + Eigen::Vector3d::Constant(0.5)); }
  void flood();

  enum : std::uint8_t { kBlocked, kFree, kReached };
  double radius_, cell_ = 0;
  Eigen::Vector3d low_;
  std::array<int, 3> cells_{};
  std::vector<std::uint8_t> state_;
};

}  // namespace spheretree::builder
