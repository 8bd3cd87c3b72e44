// SPDX-License-Identifier: GPL-3.0-or-later
// A signed distance field on a uniform grid with tricubic interpolation: what renderers of points test against.
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
  static constexpr double kSteepest = 1.2;  // that the interpolated field is taken to rise by, for each mm: a distance rises by 1

  /// As many points of 4 bytes each as `bytes` allow, 8 along an axis at least. Two cells more than the body each way.
  DistanceGrid(const builder::DistanceField& field, std::size_t bytes);

  struct Sample {
    double distance;           // negative inside
    Eigen::Vector3d gradient;  // not of unit length
  };
  /// Outside of the grid: no more than the distance to the body, and the direction away from the grid.
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
