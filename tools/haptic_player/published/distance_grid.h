// SPDX-License-Identifier: GPL-3.0-or-later
// A signed distance field on a uniform grid with tricubic interpolation, as renderers of points use it.
// Paper: E. Catmull, R. Rom. A class of local interpolating splines. Computer Aided Geometric Design, 1974 (one
// dimension at a time).
// Units: mm, mesh frame.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <vector>

#include "geometry/distance_field.h"

namespace spheretree::player {

class DistanceGrid {
 public:
  static constexpr double kSteepest = 1.2;  // assumed bound of the gradient of the interpolated field; that of a distance is 1

  /// Uses the number of 4-byte grid points that fits into `bytes`, at least 8 along each axis. The grid extends two
  /// cells beyond the body on every side.
  DistanceGrid(const builder::DistanceField& field, std::size_t bytes);

  struct Sample {
    double distance;           // negative inside
    Eigen::Vector3d gradient;  // not of unit length
  };
  /// Outside of the grid: a lower bound of the distance to the body, and the direction away from the grid.
  Sample at(const Eigen::Vector3d& p) const;
  double cell() const { return cell_; }
  std::size_t byteCount() const { return values_.size() * sizeof(float); }

 private:
  float value(int x, int y, int z) const {
    return values_[(static_cast<std::size_t>(z) * static_cast<std::size_t>(count_[1]) + static_cast<std::size_t>(y)) *
                       static_cast<std::size_t>(count_[0]) +
                   static_cast<std::size_t>(x)];
  }
  Eigen::AlignedBox3d box_;
  double cell_ = 1;
  std::array<int, 3> count_{};
  std::vector<float> values_;
};

}  // namespace spheretree::player
