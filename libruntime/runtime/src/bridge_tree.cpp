// SPDX-License-Identifier: Apache-2.0
#include "bridge_tree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numeric>

#include "block.h"
#include "search_tree.h"

namespace spheretree::runtime {
namespace {

Eigen::Vector3d centre(const Sphere& s) { return {s.x, s.y, s.z}; }

// Sorts [begin, end) of `order` so that each 8, 64, 512, ... in a row lie together.
void gather(std::span<const Sphere> spheres, std::span<std::uint32_t> order) {
  if (order.size() <= 8) return;
  std::size_t grain = 8;
  while (8 * grain < order.size()) grain *= 8;
  const std::size_t groups = (order.size() + grain - 1) / grain, half = grain * ((groups + 1) / 2);
  if (half >= order.size()) return;
  Eigen::AlignedBox3d box;
  for (const std::uint32_t i : order) box.extend(centre(spheres[i]));
  int axis = 0;
  box.sizes().maxCoeff(&axis);
  std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const double x = centre(spheres[a])[axis], y = centre(spheres[b])[axis];
    return x != y ? x < y : a < b;
  });
  gather(spheres, order.first(half));
  gather(spheres, order.subspan(half));
}

Sphere around(std::span<const Sphere> parts) {
  Eigen::AlignedBox3d box;
  for (const Sphere& s : parts) {
    const Eigen::Vector3d r = Eigen::Vector3d::Constant(static_cast<double>(s.radius));
    box.extend(centre(s) - r);
    box.extend(centre(s) + r);
  }
  const Eigen::Vector3f m = box.center().cast<float>();
  double radius = 0;
  for (const Sphere& s : parts) radius = std::max(radius, (centre(s) - m.cast<double>()).norm() + static_cast<double>(s.radius));
  return {m.x(), m.y(), m.z(), std::nextafter(static_cast<float>(radius), std::numeric_limits<float>::infinity())};
}

}  // namespace

SphereGroups::SphereGroups(std::span<const Sphere> spheres) : order_(spheres.size()) {
  if (spheres.empty()) return;
  std::iota(order_.begin(), order_.end(), 0u);
  gather(spheres, order_);
  levels_.emplace_back();
  for (const std::uint32_t i : order_) levels_.back().push_back(spheres[i]);
  while (levels_.back().size() > 1) {
    const std::vector<Sphere>& below = levels_.back();
    std::vector<Sphere> groups;
    for (std::size_t k = 0; k < below.size(); k += 8)
      groups.push_back(around(std::span(below).subspan(k, std::min<std::size_t>(8, below.size() - k))));
    levels_.push_back(std::move(groups));
  }
}

BridgeTree treeOf(std::span<const Bridge> bridges, std::span<const Sphere> around) {
  BridgeTree out;
  if (bridges.empty()) return out;
  const SphereGroups groups(around);
  const std::vector<std::vector<Sphere>>& levels = groups.levels();
  out.count = bridges.size();
  out.root = levels.back()[0];
  std::size_t blocks = 1;  // the root is alone in the first
  for (std::size_t level = 1; level < levels.size(); ++level) blocks += levels[level].size();
  out.bound.assign(blocks, emptyBlock());
  out.links.assign(blocks, {});
  out.of_slot.assign(8 * blocks, Bridge{});
  std::size_t first = 0;  // block of the first 8 of a level
  for (std::size_t level = levels.size(); level-- > 0;) {
    const std::size_t below = first + (levels[level].size() + 7) / 8;  // where the level below starts
    for (std::size_t k = 0; k < levels[level].size(); ++k) {
      const std::size_t block = first + k / 8, lane = k % 8;
      const Sphere& s = levels[level][k];
      put(out.bound[block], lane, centre(s), s.radius);
      if (level == 0) {
        out.of_slot[8 * block + lane] = bridges[groups.order()[k]];
        continue;
      }
      BlockLinks& links = out.links[block];
      if (lane == 0) links.first_child = static_cast<std::uint16_t>(below + k);
      ++links.inner;
      links.open_priority[lane] = open_priority(s.radius, std::min<std::size_t>(8, levels[level - 1].size() - 8 * k));
    }
    first = below;
  }
  return out;
}

}  // namespace spheretree::runtime
