// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/crossing_search.h"

#include <algorithm>
#include <cmath>

#include "mesh/crossing_triangles.h"

namespace spheretree::builder {

namespace {

constexpr double kCell = 3;       // side of a cube, in edges of the triangles
constexpr double kMaxCells = 64;  // largest number of cells in which a triangle is stored

}  // namespace

CrossingSearch::CrossingSearch(const std::vector<Eigen::Vector3d>& positions, double edge) : positions_(positions), cell_(kCell * edge) {}

Eigen::AlignedBox3d CrossingSearch::boxOf(const Triangle& t) const {
  Eigen::AlignedBox3d box(positions_[t[0]]);
  box.extend(positions_[t[1]]);
  box.extend(positions_[t[2]]);
  return box;
}

CrossingSearch::Cell CrossingSearch::cellOf(const Eigen::Vector3d& p) const {
  Cell cell;
  for (int axis = 0; axis < 3; ++axis)
    cell[static_cast<std::size_t>(axis)] = static_cast<std::int64_t>(std::clamp(std::floor(p[axis] / cell_), -1e15, 1e15));
  return cell;
}

double CrossingSearch::cellCount(const Cell& low, const Cell& high) {
  double count = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) count *= static_cast<double>(high[axis] - low[axis] + 1);
  return count;
}

void CrossingSearch::add(const Triangle& triangle) {
  const auto index = static_cast<std::uint32_t>(triangles_.size());
  triangles_.push_back(triangle);
  boxes_.push_back(boxOf(triangle));
  if (isFlat(positions_, triangle)) return;
  const Cell low = cellOf(boxes_.back().min()), high = cellOf(boxes_.back().max());
  if (cellCount(low, high) > kMaxCells) {
    large_.push_back(index);
    return;
  }
  for (std::int64_t x = low[0]; x <= high[0]; ++x)
    for (std::int64_t y = low[1]; y <= high[1]; ++y)
      for (std::int64_t z = low[2]; z <= high[2]; ++z) in_cell_[{x, y, z}].push_back(index);
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> CrossingSearch::against(const std::vector<Triangle>& fresh) const {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  const auto old_count = static_cast<std::uint32_t>(triangles_.size());
  std::vector<Eigen::AlignedBox3d> boxes;
  std::vector<std::uint32_t> order;  // fresh triangles that are not flat, by their lower end in x
  for (std::uint32_t i = 0; i < fresh.size(); ++i) {
    boxes.push_back(boxOf(fresh[i]));
    if (!isFlat(positions_, fresh[i])) order.push_back(i);
  }
  std::vector<std::uint32_t> found;
  for (const std::uint32_t i : order) {
    found.clear();
    const auto take = [&](std::uint32_t t) {
      if (boxes_[t].intersects(boxes[i])) found.push_back(t);
    };
    std::for_each(large_.begin(), large_.end(), take);
    const Cell low = cellOf(boxes[i].min()), high = cellOf(boxes[i].max());
    if (cellCount(low, high) > static_cast<double>(in_cell_.size())) {
      for (const auto& [unused, triangles] : in_cell_) std::for_each(triangles.begin(), triangles.end(), take);
    } else {
      for (std::int64_t x = low[0]; x <= high[0]; ++x)
        for (std::int64_t y = low[1]; y <= high[1]; ++y)
          for (auto at = in_cell_.lower_bound({x, y, low[2]}); at != in_cell_.end() && at->first <= Cell{x, y, high[2]}; ++at)
            std::for_each(at->second.begin(), at->second.end(), take);
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    for (const std::uint32_t t : found)
      if (doCross(positions_, triangles_[t], fresh[i])) pairs.emplace_back(t, old_count + i);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return boxes[a].min().x() < boxes[b].min().x(); });
  for (std::size_t i = 0; i < order.size(); ++i)
    for (std::size_t j = i + 1; j < order.size() && boxes[order[j]].min().x() <= boxes[order[i]].max().x(); ++j)
      if (boxes[order[i]].intersects(boxes[order[j]]) && doCross(positions_, fresh[order[i]], fresh[order[j]]))
        pairs.push_back(std::minmax(old_count + order[i], old_count + order[j]));
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace spheretree::builder
