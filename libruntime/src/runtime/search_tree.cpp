// SPDX-License-Identifier: Apache-2.0
#include "search_tree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace spheretree::runtime {
namespace {

constexpr std::size_t kChildren = 8;
constexpr std::size_t kManyLeaves = 8192;  // beyond, cuts keep eights together: half-empty nodes would be more than 16 bits can name

Eigen::Vector3d centreOf(const Sphere& s) { return {s.x, s.y, s.z}; }

/// Leaves that stay together, and the ball about them.
struct Part {
  std::vector<std::uint32_t> members;
  Sphere sphere;
  // Members times area: all are tested where the ball is met, and that as often as its area says.
  double cost() const {
    return static_cast<double>(members.size()) * static_cast<double>(sphere.radius) * static_cast<double>(sphere.radius);
  }
};

class Cutter {
 public:
  explicit Cutter(std::span<const Sphere> leaves) : leaves_(leaves), grain_(leaves.size() > kManyLeaves ? kChildren : 1) {}

  Part part(std::vector<std::uint32_t> members) const {
    std::vector<Sphere> spheres;
    for (const std::uint32_t m : members) spheres.push_back(leaves_[m]);
    const Sphere sphere = spheres.size() == 1 ? spheres[0] : smallestEnclosing(spheres);
    return {std::move(members), sphere};
  }

  /// The parts of a node: its members one by one, or 8 parts, of which the dearest was cut in two as long as there were fewer.
  std::vector<Part> partsOf(const Part& whole) const {
    std::vector<Part> parts;
    if (whole.members.size() <= kChildren) {
      for (const std::uint32_t m : whole.members) parts.push_back(part({m}));
      return parts;
    }
    parts.push_back(whole);
    while (parts.size() < kChildren) {
      Part* dearest = nullptr;
      for (Part& p : parts)
        if (p.members.size() > grain_ && (!dearest || p.cost() > dearest->cost())) dearest = &p;
      if (!dearest) break;
      auto [low, high] = cut(dearest->members);
      *dearest = std::move(low);
      parts.push_back(std::move(high));
    }
    std::stable_partition(parts.begin(), parts.end(), [](const Part& p) { return p.members.size() > 1; });
    return parts;
  }

 private:
  // The cost of a part that grows, with the diagonal of a box in place of a ball's.
  class BoxCost {
   public:
    double add(const Sphere& s) {
      const Eigen::Vector3d r = Eigen::Vector3d::Constant(static_cast<double>(s.radius));
      box_.extend(centreOf(s) - r);
      box_.extend(centreOf(s) + r);
      return ++count_ * box_.diagonal().squaredNorm();
    }

   private:
    Eigen::AlignedBox3d box_;
    double count_ = 0;
  };

  // In two where both together cost least: along a coordinate, the radius (large balls inside an object belong together) or the distance
  // from the middle.
  std::pair<Part, Part> cut(const std::vector<std::uint32_t>& members) const {
    const std::size_t count = members.size();
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const std::uint32_t m : members) middle += centreOf(leaves_[m]) / static_cast<double>(count);
    using Order = std::vector<std::pair<double, std::uint32_t>>;
    Order order(count), best;
    std::vector<double> low_cost(count + 1, 0);
    std::size_t best_count = 0;
    double least = std::numeric_limits<double>::infinity();
    for (int key = 0; key < 5; ++key) {
      for (std::size_t i = 0; i < count; ++i) {
        const Sphere& s = leaves_[members[i]];
        order[i] = {key < 3 ? centreOf(s)[key] : key == 3 ? static_cast<double>(s.radius) : (centreOf(s) - middle).norm(), members[i]};
      }
      std::sort(order.begin(), order.end());
      BoxCost low, high;
      for (std::size_t i = 0; i < count; ++i) low_cost[i + 1] = low.add(leaves_[order[i].second]);
      for (std::size_t i = count; i-- > 1;) {
        const double sum = low_cost[i] + high.add(leaves_[order[i].second]);
        if (i % grain_ != 0 || !(best.empty() || sum < least)) continue;
        least = sum;
        best_count = i;
        best = order;
      }
    }
    std::vector<std::uint32_t> low, high;
    for (std::size_t i = 0; i < count; ++i) (i < best_count ? low : high).push_back(best[i].second);
    return {part(std::move(low)), part(std::move(high))};
  }

  std::span<const Sphere> leaves_;
  std::size_t grain_;
};

}  // namespace

std::vector<SearchNode> makeSearchTree(std::span<const Sphere> leaves) {
  const Cutter cutter(leaves);
  std::vector<std::uint32_t> all(leaves.size());
  std::iota(all.begin(), all.end(), 0u);
  std::vector<Part> parts{cutter.part(std::move(all))};  // (nodes)
  std::vector<SearchNode> nodes;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Part part = std::move(parts[i]);
    if (part.members.size() == 1) {
      nodes.push_back({part.sphere, part.members[0]});
      continue;
    }
    std::vector<Part> children = cutter.partsOf(part);
    nodes.push_back({part.sphere, kNotALeaf, static_cast<std::uint32_t>(parts.size()), static_cast<std::uint32_t>(children.size())});
    for (Part& child : children) parts.push_back(std::move(child));
  }
  return nodes;
}

}  // namespace spheretree::runtime
