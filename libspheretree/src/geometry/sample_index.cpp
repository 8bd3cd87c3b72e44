// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/sample_index.h"

namespace spheretree::builder {

namespace {

BoxTree treeOver(std::span<const Eigen::Vector3d> points) {
  std::vector<Eigen::AlignedBox3d> boxes;
  boxes.reserve(points.size());
  for (const Eigen::Vector3d& p : points) boxes.emplace_back(p, p);
  return BoxTree(boxes, 8);
}

}  // namespace

SampleIndex::SampleIndex(std::span<const Eigen::Vector3d> samples) : tree_(treeOver(samples)), tail_begin_(samples.size()) {
  points_.reserve(samples.size());
  for (const std::uint32_t i : tree_.order()) points_.push_back(samples[i]);
}

void SampleIndex::append(const Eigen::Vector3d& point) {
  points_.push_back(point);
  if (points_.size() - tail_begin_ < kTail) return;
  // Makes a tree of the tail, together with all trees that are not larger than the points collected so far.
  std::vector<std::uint32_t> slots;
  for (; tail_begin_ < points_.size(); ++tail_begin_) slots.push_back(static_cast<std::uint32_t>(tail_begin_));
  while (!added_.empty() && added_.back().slots.size() <= slots.size()) {
    slots.insert(slots.end(), added_.back().slots.begin(), added_.back().slots.end());
    added_.pop_back();
  }
  std::vector<Eigen::Vector3d> points;
  for (const std::uint32_t slot : slots) points.push_back(points_[slot]);
  Added added{treeOver(points), {}, {}};
  for (const std::uint32_t i : added.tree.order()) {
    added.points.push_back(points[i]);
    added.slots.push_back(slots[i]);
  }
  added_.push_back(std::move(added));
}

}  // namespace spheretree::builder
