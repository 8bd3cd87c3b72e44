// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/box_tree.h"

#include <limits>
#include <numeric>

namespace spheretree::builder {

namespace {

constexpr int kBins = 16;
constexpr std::size_t kFew = 16;  // items, which are halved by count: choosing a plane costs more than searches gain by it
constexpr int kSahDepth = 40;     // below this depth, halve by count: bounds the depth at 40 + log2(n) / 2 for any input

double halfArea(const Eigen::AlignedBox3d& box) {
  if (box.isEmpty()) return 0;
  const Eigen::Vector3d s = box.sizes();
  return s.x() * s.y() + s.y() * s.z() + s.z() * s.x();
}

struct Range {
  std::size_t first = 0, last = 0;
  Eigen::AlignedBox3d box;
  std::size_t size() const { return last - first; }
};

}  // namespace

BoxTree::BoxTree(std::span<const Eigen::AlignedBox3d> boxes, int leaf_size) : order_(boxes.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  if (boxes.empty()) return;
  const auto wanted = static_cast<std::size_t>(std::max(leaf_size, 1));
  std::vector<Eigen::Vector3d> centre(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) centre[i] = 0.5 * (boxes[i].min() + boxes[i].max());

  const auto boxOf = [&](std::size_t first, std::size_t last) {
    Eigen::AlignedBox3d box;
    for (std::size_t i = first; i < last; ++i) box.extend(boxes[order_[i]]);
    return box;
  };
  const auto byCentre = [&](int axis) {
    return [&centre, axis](std::uint32_t a, std::uint32_t b) {
      const double ca = centre[a][axis], cb = centre[b][axis];
      return ca != cb ? ca < cb : a < b;
    };
  };
  const auto split = [&](const Range& range, int depth) -> std::array<Range, 2> {
    Eigen::AlignedBox3d centres;
    for (std::size_t i = range.first; i < range.last; ++i) centres.extend(centre[order_[i]]);
    int best_axis = -1, best_bin = 0;
    double best_cost = std::numeric_limits<double>::infinity();
    if (range.size() > kFew && depth < kSahDepth) {
      for (int axis = 0; axis < 3; ++axis) {
        const double low = centres.min()[axis], width = centres.max()[axis] - low;
        if (!(width > 0)) continue;
        std::array<Eigen::AlignedBox3d, kBins> bin_box;
        std::array<std::size_t, kBins> bin_count{};
        for (std::size_t i = range.first; i < range.last; ++i) {
          const auto b = static_cast<std::size_t>(std::min(kBins - 1, static_cast<int>((centre[order_[i]][axis] - low) / width * kBins)));
          bin_box[b].extend(boxes[order_[i]]);
          ++bin_count[b];
        }
        std::array<double, kBins> right_cost{};
        Eigen::AlignedBox3d right;
        std::size_t right_count = 0;
        for (std::size_t b = kBins; b-- > 1;) {
          right.extend(bin_box[b]);
          right_count += bin_count[b];
          right_cost[b] = halfArea(right) * static_cast<double>(right_count);
        }
        Eigen::AlignedBox3d left;
        std::size_t left_count = 0;
        for (std::size_t b = 0; b + 1 < kBins; ++b) {
          left.extend(bin_box[b]);
          left_count += bin_count[b];
          if (left_count == 0 || left_count == range.size()) continue;
          const double cost = halfArea(left) * static_cast<double>(left_count) + right_cost[b + 1];
          if (cost < best_cost) best_cost = cost, best_axis = axis, best_bin = static_cast<int>(b);
        }
      }
    }
    const auto begin = order_.begin() + static_cast<std::ptrdiff_t>(range.first);
    const auto end = order_.begin() + static_cast<std::ptrdiff_t>(range.last);
    std::size_t middle = range.first + range.size() / 2;
    if (best_axis >= 0) {
      const double low = centres.min()[best_axis], width = centres.max()[best_axis] - low;
      const auto at = std::stable_partition(begin, end, [&](std::uint32_t i) {
        return std::min(kBins - 1, static_cast<int>((centre[i][best_axis] - low) / width * kBins)) <= best_bin;
      });
      middle = static_cast<std::size_t>(at - order_.begin());
    } else {  // few; too deep, or all centres equal: halve, so that the depth stays bounded
      int axis = 0;
      centres.sizes().maxCoeff(&axis);
      std::nth_element(begin, order_.begin() + static_cast<std::ptrdiff_t>(middle), end, byCentre(axis));
    }
    return {Range{range.first, middle, boxOf(range.first, middle)}, Range{middle, range.last, boxOf(middle, range.last)}};
  };

  const Range all{0, boxes.size(), boxOf(0, boxes.size())};
  middle_ = all.box.center();
  const double reach = 0.5 * all.box.sizes().maxCoeff();
  to_local_ = reach > 1e-150 ? 1 / reach : 0;  // 0: all in one place
  from_local2_ = kShrink * reach * reach;
  constexpr float kFar = std::numeric_limits<float>::infinity();
  struct Task {
    Range range;
    std::size_t node;
    int depth;
  };
  std::vector<Task> tasks;
  nodes_.emplace_back();
  tasks.push_back({all, 0, 0});
  while (!tasks.empty()) {
    const Task task = tasks.back();
    tasks.pop_back();
    // Open the largest of the children until there are four.
    std::vector<Range> children{task.range};
    while (children.size() < 4) {
      std::size_t pick = children.size();
      double most = -1;
      for (std::size_t i = 0; i < children.size(); ++i)
        if (children[i].size() > wanted && halfArea(children[i].box) > most) most = halfArea(children[i].box), pick = i;
      if (pick == children.size()) break;
      const auto halves = split(children[pick], task.depth);
      children[pick] = halves[0];
      children.push_back(halves[1]);
    }
    Node node{};
    for (std::size_t k = 0; k < 4; ++k) {
      const bool used = k < children.size();
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<Eigen::Index>(axis);
        const auto column = static_cast<Eigen::Index>(k);
        node.low[axis][column] = used ? static_cast<float>((children[k].box.min()[i] - middle_[i]) * to_local_ - kHair) : kFar;
        node.high[axis][column] = used ? static_cast<float>((children[k].box.max()[i] - middle_[i]) * to_local_ + kHair) : kFar;
      }
      if (!used) continue;
      if (children[k].size() <= wanted) {
        node.child[k] = static_cast<std::int32_t>(children[k].first);
        node.count[k] = static_cast<std::int32_t>(children[k].size());
      } else {
        node.child[k] = static_cast<std::int32_t>(nodes_.size());
        node.count[k] = -1;
        tasks.push_back({children[k], nodes_.size(), task.depth + 1});
        nodes_.emplace_back();
      }
    }
    nodes_[task.node] = node;
  }
}

void BoxTree::addSlabs(std::span<const std::array<Eigen::Vector3d, 3>> triangles) {
  using Eigen::Vector3d;
  slabs_.resize(nodes_.size());
  struct Slots {
    std::size_t first, last;
  };
  std::vector<Slots> below(nodes_.size());
  for (std::size_t i = nodes_.size(); i-- > 0;) {  // children come after their parents
    below[i] = {triangles.size(), 0};
    for (std::size_t k = 0; k < 4; ++k) {
      const Node& node = nodes_[i];
      const auto child = static_cast<std::size_t>(node.child[k]);
      Slots slots{0, 0};
      if (node.count[k] > 0) slots = {child, child + static_cast<std::size_t>(node.count[k])};
      if (node.count[k] < 0) slots = below[child];
      Vector3d area = Vector3d::Zero();
      for (std::size_t s = slots.first; s < slots.last; ++s) {
        const Vector3d ab = (triangles[s][1] - triangles[s][0]) * to_local_, ac = (triangles[s][2] - triangles[s][0]) * to_local_;
        area += ab.cross(ac);
      }
      // No longer than 1, rounded or not. Zero where the triangles have no area or there are none: such a slab is everywhere.
      const Eigen::Vector3f normal = (area.stableNormalized() * (1 - kHair)).cast<float>();
      double low = 0, high = 0;
      for (std::size_t s = slots.first; s < slots.last; ++s)
        for (const Vector3d& corner : triangles[s]) {
          const double height = normal.cast<double>().dot((corner - middle_) * to_local_);
          const bool is_first = s == slots.first && &corner == &triangles[s][0];
          low = is_first ? height : std::min(low, height);
          high = is_first ? height : std::max(high, height);
        }
      const auto column = static_cast<Eigen::Index>(k);
      for (std::size_t axis = 0; axis < 3; ++axis) slabs_[i].normal[axis][column] = normal[static_cast<Eigen::Index>(axis)];
      slabs_[i].low[column] = static_cast<float>(low - 8 * kHair);
      slabs_[i].high[column] = static_cast<float>(high + 8 * kHair);
      if (node.count[k] != 0) below[i] = {std::min(below[i].first, slots.first), std::max(below[i].last, slots.last)};
    }
  }
}

}  // namespace spheretree::builder
