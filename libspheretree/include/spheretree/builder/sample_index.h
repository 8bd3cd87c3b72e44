// SPDX-License-Identifier: GPL-3.0-or-later
// Points in the order of a box tree over them, so that a search reads runs of memory. A few points can be added behind it.
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "spheretree/builder/box_tree.h"

namespace spheretree::builder {

class SampleIndex {
 public:
  explicit SampleIndex(std::span<const Eigen::Vector3d> samples);
  std::size_t size() const { return points_.size(); }
  /// Adds a point in the next slot. Searches go through all added points one by one: for a few hundred.
  void append(const Eigen::Vector3d& point) { points_.push_back(point); }
  std::size_t appended() const { return points_.size() - tree_.order().size(); }
  /// By slot, which is not the index in the span given: points near each other have slots near each other.
  const Eigen::Vector3d& operator[](std::size_t slot) const { return points_[slot]; }

  /// visit(slot, distance) for the points within `radius` of `centre`, touching included, in a fixed order.
  template <class Visit>
  void within(const Eigen::Vector3d& centre, double radius, Visit visit) const {
    if (!(radius >= 0)) return;
    const double radius2 = radius * radius;
    tree_.searchWithin(centre, radius2, [&](std::size_t first, std::size_t count) {
      for (std::size_t i = first; i < first + count; ++i) {
        const double d2 = (points_[i] - centre).squaredNorm();
        if (d2 <= radius2) visit(static_cast<std::uint32_t>(i), std::sqrt(d2));
      }
    });
    for (std::size_t i = tree_.order().size(); i < points_.size(); ++i) {
      const double d2 = (points_[i] - centre).squaredNorm();
      if (d2 <= radius2) visit(static_cast<std::uint32_t>(i), std::sqrt(d2));
    }
  }

 private:
  BoxTree tree_;
  std::vector<Eigen::Vector3d> points_;
};

}  // namespace spheretree::builder
