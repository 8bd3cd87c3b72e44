// SPDX-License-Identifier: GPL-3.0-or-later
// The space that a ball can reach when it moves from outside through the free space between solids, and the triangles
// that it may touch. The result is conservative: a triangle that the ball can touch is always called reached. A
// triangle that it cannot touch may also be called reached, if the passage or the place is too narrow for the ball by
// less than the cell size.
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
  /// `solids`: closed meshes, oriented outward; they may overlap. `radius` of the ball, > 0. The cell size is half of
  /// the radius or 1/400 of the scene's diagonal, whichever is larger.
  /// Cost: about one distance query for each cell near a surface; a mouth of 33 objects takes some seconds of processor
  /// time.
  /// @throws Cancelled, std::invalid_argument for no solids or a radius that is not positive.
  ReachableSpace(std::span<const TriangleMesh> solids, double radius, Progress& progress);

  /// A flag for each triangle of `mesh`: whether the ball may touch it.
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
