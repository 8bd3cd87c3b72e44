// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/sample_index.h"

namespace spheretree::builder {

SampleIndex::SampleIndex(std::span<const Eigen::Vector3d> samples) {
  std::vector<Eigen::AlignedBox3d> boxes;
  boxes.reserve(samples.size());
  for (const Eigen::Vector3d& p : samples) boxes.emplace_back(p, p);
  tree_ = BoxTree(boxes, 8);
  points_.reserve(samples.size());
  for (const std::uint32_t i : tree_.order()) points_.push_back(samples[i]);
}

}  // namespace spheretree::builder
