// SPDX-License-Identifier: GPL-3.0-or-later
// Points in the order of box trees over them, so that a search reads contiguous memory. Points can be added at any
// time: they are kept in trees of doubling sizes (the logarithmic method of J. L. Bentley and J. B. Saxe, Journal of
// Algorithms 1(4), 1980).
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "geometry/box_tree.h"

namespace spheretree::builder {

class SampleIndex {
 public:
  explicit SampleIndex(std::span<const Eigen::Vector3d> samples);
  std::size_t size() const { return points_.size(); }
  /// Adds a point in the next slot. O(log^2 n), amortised.
  void append(const Eigen::Vector3d& point);
  /// By slot, which is not the index in the given span: points near each other have slots near each other.
  const Eigen::Vector3d& operator[](std::size_t slot) const { return points_[slot]; }

  /// Calls visit(slot, distance) for all points with a distance of at most `radius` from `centre`, in a fixed order.
  template <class Visit>
  void within(const Eigen::Vector3d& centre, double radius, Visit visit) const {
    if (!(radius >= 0)) return;
    const double radius2 = radius * radius;
    const auto visitNear = [&](const Eigen::Vector3d& p, std::uint32_t slot) {
      const double d2 = (p - centre).squaredNorm();
      if (d2 <= radius2) visit(slot, std::sqrt(d2));
    };
    tree_.searchWithin(centre, radius2, [&](std::size_t first, std::size_t count) {
      for (std::size_t i = first; i < first + count; ++i) visitNear(points_[i], static_cast<std::uint32_t>(i));
    });
    for (const Added& added : added_)
      added.tree.searchWithin(centre, radius2, [&](std::size_t first, std::size_t count) {
        for (std::size_t i = first; i < first + count; ++i) visitNear(added.points[i], added.slots[i]);
      });
    for (std::size_t i = tail_begin_; i < points_.size(); ++i) visitNear(points_[i], static_cast<std::uint32_t>(i));
  }

 private:
  struct Added {  // points in the order of the tree, with the slot of each
    BoxTree tree;
    std::vector<Eigen::Vector3d> points;
    std::vector<std::uint32_t> slots;
  };
  static constexpr std::size_t kTail = 64;  // points that a search tests one by one

  BoxTree tree_;  // of the points given to the constructor
  std::vector<Eigen::Vector3d> points_;
  std::vector<Added> added_;    // each at least twice as large as the next
  std::size_t tail_begin_ = 0;  // first slot that is in no tree
};

}  // namespace spheretree::builder
