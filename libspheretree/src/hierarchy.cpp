// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/hierarchy.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>

#include "spheretree/builder/ball.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr int kCentring = 12;           // steps towards the centre of an enclosing ball: within a few per cent
constexpr std::size_t kNeighbours = 6;  // parents that a child is tried under
constexpr int kPasses = 4;
constexpr double kWorthwhile = 1e-9;  // relative gain below which a swap is rounding

Ball toBall(const Sphere& s) { return {Vector3d(s.x, s.y, s.z), s.radius}; }

// A small ball about some balls. Method: M. Badoiu, K. Clarkson. Smaller core-sets for balls. SODA 2003.
Ball enclosing(const std::vector<Ball>& balls) {
  Vector3d c = Vector3d::Zero();
  for (const Ball& b : balls) c += b.centre;
  c /= static_cast<double>(balls.size());
  Ball best{c, std::numeric_limits<double>::infinity()};
  for (int i = 0; i < kCentring; ++i) {
    double most = 0;
    const Ball* far = nullptr;
    for (const Ball& b : balls) {
      const double reach = (b.centre - c).norm() + b.radius;
      if (reach > most) most = reach, far = &b;
    }
    if (most < best.radius) best = {c, most};
    const Vector3d to = far->centre - c;
    const double distance = to.norm();
    if (!(distance > 0)) break;
    c += to * ((most / distance) / (i + 2) * 0.5);
  }
  return best;
}

class Grouping {
 public:
  Grouping(const std::vector<Ball>& parents, const std::vector<Ball>& children, std::size_t capacity)
      : parents_(parents),
        children_(children),
        capacity_(capacity),
        members_(parents.size()),
        parent_(children.size()),
        bound_(parents.size()) {
    assignAll();
    fillEmpty();
    for (std::size_t p = 0; p < parents_.size(); ++p) bound_[p] = boundOf(p, members_[p]);
    for (int pass = 0; pass < kPasses && improve(); ++pass) {
    }
  }
  const std::vector<std::uint32_t>& parent() const { return parent_; }
  const std::vector<Ball>& bounds() const { return bound_; }

 private:
  static double cost(const Ball& b) { return b.radius * b.radius; }

  Ball boundOf(std::size_t p, const std::vector<std::uint32_t>& members) const {
    scratch_.clear();
    scratch_.push_back(parents_[p]);
    for (const std::uint32_t c : members) scratch_.push_back(children_[c]);
    return enclosing(scratch_);
  }

  // Compact groups by halving the children across their longest extent, in the proportion of the parents on either side; then each
  // group to the parent whose own sphere it goes with best.
  void assignAll() {
    std::vector<std::uint32_t> order(children_.size());
    std::iota(order.begin(), order.end(), 0u);
    std::vector<std::vector<std::uint32_t>> groups;
    struct Part {
      std::size_t first, last, parents;
    };
    std::vector<Part> parts{{0, order.size(), parents_.size()}};
    while (!parts.empty()) {
      const Part part = parts.back();
      parts.pop_back();
      if (part.parents == 1) {
        groups.emplace_back(order.begin() + static_cast<std::ptrdiff_t>(part.first),
                            order.begin() + static_cast<std::ptrdiff_t>(part.last));
        continue;
      }
      Eigen::AlignedBox3d box;
      for (std::size_t i = part.first; i < part.last; ++i) box.extend(children_[order[i]].centre);
      int axis = 0;
      if (!box.isEmpty()) box.sizes().maxCoeff(&axis);
      const std::size_t count = part.last - part.first, left = part.parents / 2, right = part.parents - left;
      std::size_t here = (count * left + part.parents / 2) / part.parents;
      here = std::min(here, left * capacity_);
      if (count - here > right * capacity_) here = count - right * capacity_;
      std::sort(order.begin() + static_cast<std::ptrdiff_t>(part.first), order.begin() + static_cast<std::ptrdiff_t>(part.last),
                [&](std::uint32_t x, std::uint32_t y) {
                  const double cx = children_[x].centre[axis], cy = children_[y].centre[axis];
                  return cx != cy ? cx < cy : x < y;
                });
      parts.push_back({part.first + here, part.last, right});
      parts.push_back({part.first, part.first + here, left});
    }
    // Greedy by the ball about both, then exchanges.
    std::vector<Ball> about;
    for (const auto& group : groups) {
      scratch_.clear();
      for (const std::uint32_t c : group) scratch_.push_back(children_[c]);
      about.push_back(scratch_.empty() ? Ball{} : enclosing(scratch_));
    }
    const auto price = [&](std::size_t g, std::size_t p) {
      if (groups[g].empty()) return cost(parents_[p]);
      const double distance = (about[g].centre - parents_[p].centre).norm();
      const double radius = std::max({about[g].radius, parents_[p].radius, 0.5 * (distance + about[g].radius + parents_[p].radius)});
      return radius * radius;
    };
    std::vector<std::size_t> of_parent(parents_.size());  // group of each parent
    std::vector<char> taken(groups.size(), 0);
    std::vector<std::size_t> by_size(parents_.size());
    std::iota(by_size.begin(), by_size.end(), std::size_t{0});
    std::stable_sort(by_size.begin(), by_size.end(), [&](std::size_t x, std::size_t y) { return parents_[x].radius > parents_[y].radius; });
    for (const std::size_t p : by_size) {
      std::size_t best = groups.size();
      for (std::size_t g = 0; g < groups.size(); ++g)
        if (!taken[g] && (best == groups.size() || price(g, p) < price(best, p))) best = g;
      taken[best] = 1;
      of_parent[p] = best;
    }
    for (int pass = 0, changed = 1; pass < kPasses && changed; ++pass) {
      changed = 0;
      for (std::size_t p = 0; p < parents_.size(); ++p)
        for (std::size_t q = p + 1; q < parents_.size(); ++q) {
          const double now = price(of_parent[p], p) + price(of_parent[q], q);
          if (price(of_parent[q], p) + price(of_parent[p], q) < now * (1 - kWorthwhile)) std::swap(of_parent[p], of_parent[q]), changed = 1;
        }
    }
    for (std::uint32_t p = 0; p < parents_.size(); ++p)
      for (const std::uint32_t c : groups[of_parent[p]]) join(c, p);
    // A child is later tried under the parents whose groups are nearest.
    near_.resize(children_.size());
    std::vector<std::pair<double, std::uint32_t>> by_distance(parents_.size());
    for (std::uint32_t c = 0; c < children_.size(); ++c) {
      for (std::uint32_t p = 0; p < parents_.size(); ++p) {
        const Ball& group = about[of_parent[p]];
        by_distance[p] = {(children_[c].centre - group.centre).norm() + children_[c].radius - group.radius, p};
      }
      const std::size_t kept = std::min(by_distance.size(), kNeighbours);
      std::partial_sort(by_distance.begin(), by_distance.begin() + static_cast<std::ptrdiff_t>(kept), by_distance.end());
      for (std::size_t i = 0; i < kept; ++i) near_[c].push_back(by_distance[i].second);
    }
  }
  void join(std::uint32_t child, std::uint32_t parent) {
    members_[parent].push_back(child);
    parent_[child] = parent;
  }

  // A parent without a child takes the nearest one whose parent has others.
  void fillEmpty() {
    for (std::uint32_t p = 0; p < parents_.size(); ++p) {
      if (!members_[p].empty()) continue;
      std::uint32_t best = kNoParent;
      double least = std::numeric_limits<double>::infinity();
      for (std::uint32_t c = 0; c < children_.size(); ++c) {
        const double distance = (children_[c].centre - parents_[p].centre).norm();
        if (members_[parent_[c]].size() > 1 && distance < least) least = distance, best = c;
      }
      if (best == kNoParent) return;
      auto& from = members_[parent_[best]];
      from.erase(std::find(from.begin(), from.end(), best));
      join(best, p);
    }
  }

  // One pass of moves and swaps. False if nothing improved.
  bool improve() {
    bool any = false;
    for (std::uint32_t c = 0; c < children_.size(); ++c) {
      const std::uint32_t a = parent_[c];
      std::vector<std::uint32_t> without = members_[a];
      without.erase(std::find(without.begin(), without.end(), c));
      const double before_a = cost(bound_[a]), freed = before_a - cost(boundOf(a, without));
      if (!(freed > kWorthwhile * before_a)) continue;  // it is not what makes its parent large
      double best_gain = kWorthwhile * before_a;
      std::uint32_t best_parent = a, best_other = kNoParent;
      for (const std::uint32_t b : near_[c]) {
        if (b == a) continue;
        const double before = before_a + cost(bound_[b]);
        std::vector<std::uint32_t> with = members_[b];
        with.push_back(c);
        if (members_[b].size() < capacity_ && !without.empty()) {
          const double gain = before - cost(boundOf(a, without)) - cost(boundOf(b, with));
          if (gain > best_gain) best_gain = gain, best_parent = b, best_other = kNoParent;
        }
        for (std::size_t i = 0; i < members_[b].size(); ++i) {
          const std::uint32_t other = members_[b][i];
          // The other must not be hopeless where it would go.
          if ((children_[other].centre - bound_[a].centre).norm() + children_[other].radius > 1.5 * bound_[a].radius) continue;
          std::vector<std::uint32_t> new_a = without, new_b = members_[b];
          new_a.push_back(other);
          new_b[i] = c;
          const double cost_a = cost(boundOf(a, new_a));
          if (before - cost_a <= best_gain) continue;
          const double gain = before - cost_a - cost(boundOf(b, new_b));
          if (gain > best_gain) best_gain = gain, best_parent = b, best_other = other;
        }
      }
      if (best_parent == a) continue;
      any = true;
      members_[a] = std::move(without);
      if (best_other != kNoParent) {
        auto& from = members_[best_parent];
        from.erase(std::find(from.begin(), from.end(), best_other));
        join(best_other, a);
      }
      join(c, best_parent);
      bound_[a] = boundOf(a, members_[a]);
      bound_[best_parent] = boundOf(best_parent, members_[best_parent]);
    }
    return any;
  }

  const std::vector<Ball>& parents_;
  const std::vector<Ball>& children_;
  std::size_t capacity_;
  std::vector<std::vector<std::uint32_t>> members_, near_;
  std::vector<std::uint32_t> parent_;
  std::vector<Ball> bound_;
  mutable std::vector<Ball> scratch_;
};

}  // namespace

std::vector<std::vector<std::uint32_t>> groupLevels(const std::vector<std::vector<Sphere>>& levels, int branching) {
  std::vector<std::vector<std::uint32_t>> parents(levels.size());
  std::vector<Ball> below;
  if (!levels.empty())
    for (const Sphere& s : levels.back()) below.push_back(toBall(s));
  for (std::size_t level = levels.size(); level-- > 1;) {
    if (levels[level].size() > levels[level - 1].size() * static_cast<std::size_t>(branching))
      throw std::invalid_argument("hierarchy: level " + std::to_string(level) + " has more spheres than its parents may have children");
    std::vector<Ball> above;
    for (const Sphere& s : levels[level - 1]) above.push_back(toBall(s));
    const Grouping grouping(above, below, static_cast<std::size_t>(branching));
    parents[level] = grouping.parent();
    below = grouping.bounds();
  }
  return parents;
}

std::vector<std::size_t> levelCounts(std::size_t leaves, int branching) {
  const auto full = static_cast<std::size_t>(branching);
  std::vector<std::size_t> most{1};  // of each level
  while (most.back() < leaves) most.push_back(most.back() * full);
  std::vector<std::size_t> counts(most.size(), leaves);
  for (std::size_t level = counts.size() - 1; level-- > 0;)
    counts[level] = std::min(most[level], (4 * counts[level + 1] + 3 * full - 1) / (3 * full));
  return counts;
}

SphereTree assembleTree(const std::vector<std::vector<Sphere>>& levels, const std::vector<std::vector<std::uint32_t>>& parents,
                        int branching) {
  if (levels.empty() || levels[0].size() != 1 || parents.size() != levels.size())
    throw std::invalid_argument("hierarchy: level 0 must be one sphere");
  std::vector<std::vector<std::vector<std::uint32_t>>> children(levels.size());  // (level)(sphere) -> indices on the next level
  for (std::size_t level = 0; level < levels.size(); ++level) children[level].resize(levels[level].size());
  for (std::size_t level = 1; level < levels.size(); ++level) {
    if (parents[level].size() != levels[level].size()) throw std::invalid_argument("hierarchy: a sphere without a parent");
    for (std::uint32_t i = 0; i < parents[level].size(); ++i) {
      if (parents[level][i] >= levels[level - 1].size()) throw std::invalid_argument("hierarchy: a parent out of range");
      children[level - 1][parents[level][i]].push_back(i);
    }
  }
  SphereTree tree;
  tree.branching = static_cast<std::uint8_t>(branching);
  std::vector<std::uint32_t> row{0};
  for (std::size_t level = 0; level < levels.size() && !row.empty(); ++level) {
    std::vector<std::uint32_t> next;
    for (const std::uint32_t i : row) {
      std::vector<std::uint32_t>& mine = children[level][i];
      if (mine.size() > static_cast<std::size_t>(branching)) throw std::invalid_argument("hierarchy: a sphere with too many children");
      // Those with children of their own first, as the file asks; otherwise in the order given.
      if (level + 1 < levels.size())
        std::stable_partition(mine.begin(), mine.end(), [&](std::uint32_t c) { return !children[level + 1][c].empty(); });
      tree.cover.push_back(levels[level][i]);
      tree.child_count.push_back(static_cast<std::uint8_t>(mine.size()));
      next.insert(next.end(), mine.begin(), mine.end());
    }
    row = std::move(next);
  }
  if (!linkNodes(tree)) throw std::invalid_argument("hierarchy: the parents make no tree");
  encloseDescendants(tree);
  countLevels(tree);
  return tree;
}

}  // namespace spheretree::builder
