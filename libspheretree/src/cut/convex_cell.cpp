// SPDX-License-Identifier: GPL-3.0-or-later
#include "cut/convex_cell.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "spheretree/core/rounding.h"

namespace spheretree::builder {

using Eigen::Vector3d;

void ConvexCell::reset(double half) {
  half_ = half;
  corners_.clear();
  loops_.clear();
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-half, half}) {
      loops_.push_back({static_cast<std::uint32_t>(corners_.size()), 4});
      for (const auto& [u, v] : {std::pair(-half, -half), std::pair(half, -half), std::pair(half, half), std::pair(-half, half)}) {
        Vector3d p;
        p[axis] = side, p[(axis + 1) % 3] = u, p[(axis + 2) % 3] = v;
        corners_.push_back(p);
      }
    }
}

void ConvexCell::clip(const HalfSpace& kept) {
  height_.resize(corners_.size());
  // Faces store their corners separately: those of one point must be on the same side of a plane through it.
  const double rounding = kRounding * half_ * kept.normal.norm();
  bool cuts = false, keeps = false;
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    height_[i] = kept.normal.dot(corners_[i]) + kept.offset;
    if (std::abs(height_[i]) <= rounding) height_[i] = 0;
    cuts = cuts || height_[i] > 0;
    keeps = keeps || height_[i] < 0;
  }
  if (!cuts) return;
  if (!keeps) return loops_.clear(), corners_.clear();
  next_corners_.clear();
  next_loops_.clear();
  rim_.clear();
  for (const Loop& loop : loops_) {
    const auto first = static_cast<std::uint32_t>(next_corners_.size());
    for (std::uint32_t k = 0; k < loop.count; ++k) {
      const std::size_t i = loop.first + k, j = loop.first + (k + 1) % loop.count;
      const double a = height_[i], b = height_[j];
      if (a <= 0) next_corners_.push_back(corners_[i]);
      if ((a <= 0) == (b <= 0)) continue;
      const Vector3d crossing = corners_[i] + a / (a - b) * (corners_[j] - corners_[i]);
      next_corners_.push_back(crossing);
      rim_.push_back(crossing);
    }
    const auto count = static_cast<std::uint32_t>(next_corners_.size()) - first;
    if (count >= 3)
      next_loops_.push_back({first, count});
    else
      next_corners_.resize(first);
  }
  if (rim_.size() >= 3) {  // the new face: the rim is convex, so that angles about its middle give its order
    Vector3d middle = Vector3d::Zero();
    for (const Vector3d& p : rim_) middle += p / static_cast<double>(rim_.size());
    const Vector3d n = kept.normal.normalized(), u = n.unitOrthogonal(), v = n.cross(u);
    const auto angle = [&](const Vector3d& p) { return std::atan2((p - middle).dot(v), (p - middle).dot(u)); };
    std::sort(rim_.begin(), rim_.end(), [&](const Vector3d& a, const Vector3d& b) { return angle(a) < angle(b); });
    next_loops_.push_back({static_cast<std::uint32_t>(next_corners_.size()), static_cast<std::uint32_t>(rim_.size())});
    next_corners_.insert(next_corners_.end(), rim_.begin(), rim_.end());
  }
  corners_.swap(next_corners_);
  loops_.swap(next_loops_);
}

double ConvexCell::volume() const {
  if (loops_.empty()) return 0;
  const Vector3d& apex = corners_[loops_.front().first];
  double volume = 0;
  for (const Loop& loop : loops_) {  // each face and the apex are the ends of a pyramid
    const Vector3d& p = corners_[loop.first];
    Vector3d area = Vector3d::Zero();
    for (std::uint32_t k = 1; k + 1 < loop.count; ++k) area += (corners_[loop.first + k] - p).cross(corners_[loop.first + k + 1] - p);
    volume += std::abs(area.dot(p - apex)) / 6;
  }
  return volume;
}

}  // namespace spheretree::builder
