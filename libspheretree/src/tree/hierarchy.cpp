// SPDX-License-Identifier: GPL-3.0-or-later
#include "tree/hierarchy.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <stdexcept>
#include <string>

#include "base/ball.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr int kCentring = 6;            // steps towards the centre of an enclosing ball: accurate to a few per cent
constexpr int kCuts = 16;               // positions that are tried for a cut of a part, along each key
constexpr std::size_t kNeighbours = 6;  // groups that are tried for a child
constexpr int kPasses = 8;
constexpr double kWorthwhile = 1e-9;  // relative gain below which an exchange is attributed to rounding

Ball scaledBall(const Sphere& s, double scale) { return {scale * centreOf(s), scale * s.radius}; }

void extendBy(const Ball& ball, Eigen::AlignedBox3d& box) {
  box.extend(ball.centre - Vector3d::Constant(ball.radius));
  box.extend(ball.centre + Vector3d::Constant(ball.radius));
}

// An approximately smallest ball around some balls. Method: M. Badoiu, K. Clarkson. Smaller core-sets for balls. SODA
// 2003.
Ball enclosing(std::span<const Ball> balls) {
  Eigen::AlignedBox3d box;
  for (const Ball& b : balls) extendBy(b, box);
  Vector3d c = box.center();
  Ball best{c, std::numeric_limits<double>::infinity()};
  for (int i = 0; i < kCentring; ++i) {
    double largest = 0;
    const Ball* far = nullptr;
    for (const Ball& b : balls) {
      const double reach = (b.centre - c).norm() + b.radius;
      if (reach > largest) largest = reach, far = &b;
    }
    if (largest < best.radius) best = {c, largest};
    const Vector3d to = far->centre - c;
    const double distance = to.norm();
    if (!(distance > 0)) break;
    c += to * ((largest / distance) / (i + 2) * 0.5);
  }
  return best;
}

// Radius of the smallest ball around two balls.
double jointRadius(const Ball& a, const Ball& b) {
  return std::max({a.radius, b.radius, 0.5 * ((a.centre - b.centre).norm() + a.radius + b.radius)});
}

// Groups of children, one for each parent's own sphere; if more groups are allowed than there are parents, the others
// have no such sphere.
class Grouping {
 public:
  Grouping(const std::vector<Ball>& parents, const std::vector<Ball>& children, std::size_t capacity, std::size_t groups)
      : parents_(parents), children_(children), capacity_(capacity), group_of_(children.size()) {
    cutAll(groups);
    matchParents(true);
    fillEmpty();
    boundAll();
    for (int pass = 0; pass < kPasses; ++pass) {
      const bool moved = exchangeChildren();
      if (!matchParents(false) && !moved) break;
      boundAll();
    }
    std::erase_if(groups_, [](const Group& g) { return g.parent == kNone && g.members.empty(); });
  }

  struct Group {
    std::vector<std::uint32_t> members;
    std::uint32_t parent = kNone;
    Ball inner, bound;  // enclosing the members; also enclosing the parent's own sphere
    int changed = 0;    // pass of its last change
  };
  const std::vector<Group>& groups() const { return groups_; }
  static double cost(const Group& g) { return cost(g.members.size(), g.bound.radius); }

 private:
  // Every child is tested whenever the bounding sphere is touched. The frequency of this grows far slower than the
  // area: two objects touch at their ends and edges more often than elsewhere, and beyond the size of the other object
  // it hardly grows at all. Therefore one far too large bound with few children is better than many bounds that are
  // slightly too large. Exponents of 0.2 to 0.5 gave the same number of node pairs within 5 %, an exponent of 1 a tenth
  // more, 2 half as many again.
  static double cost(std::size_t members, double radius) { return static_cast<double>(members) * std::cbrt(radius); }
  Ball boundOf(std::uint32_t parent, std::span<const std::uint32_t> members) const {
    scratch_.clear();
    for (const std::uint32_t c : members) scratch_.push_back(children_[c]);
    if (parent != kNone) scratch_.push_back(parents_[parent]);
    return scratch_.empty() ? Ball{} : enclosing(scratch_);
  }
  void boundAll() {
    for (Group& g : groups_) {
      g.inner = boundOf(kNone, g.members);
      g.bound = boundOf(g.parent, g.members);
    }
  }

  // Makes compact groups, from the whole set down: a part is cut in two where the cost of both is smallest, and each
  // half gets half of its groups.
  void cutAll(std::size_t groups) {
    struct Part {
      std::vector<std::uint32_t> members;
      std::size_t groups;
    };
    std::vector<Part> parts(1);
    parts[0].groups = groups;
    for (std::uint32_t c = 0; c < children_.size(); ++c) parts[0].members.push_back(c);
    while (!parts.empty()) {
      Part part = std::move(parts.back());
      parts.pop_back();
      if (part.groups == 1) {
        groups_.emplace_back().members = std::move(part.members);
        continue;
      }
      const std::size_t left = part.groups / 2, right = part.groups - left;
      const std::size_t here = cut(part.members, left, right);
      const auto middle = part.members.begin() + static_cast<std::ptrdiff_t>(here);
      parts.push_back({{middle, part.members.end()}, right});
      parts.push_back({{part.members.begin(), middle}, left});
    }
    for (std::uint32_t g = 0; g < groups_.size(); ++g)
      for (const std::uint32_t c : groups_[g].members) group_of_[c] = g;
  }

  // Orders the members and returns how many go to the left such that no group has to be empty or too full. Keys: the
  // coordinates, the radius (large balls inside an object are best kept together) and the distance from the middle.
  std::size_t cut(std::vector<std::uint32_t>& members, std::size_t left, std::size_t right) const {
    const std::size_t count = members.size();
    const std::size_t min_left = std::max(count - std::min(count, right * capacity_), std::min(left, count));
    const std::size_t max_left = std::max(min_left, std::min(left * capacity_, count - std::min(right, count - min_left)));
    Vector3d middle = Vector3d::Zero();
    for (const std::uint32_t c : members) middle += children_[c].centre / static_cast<double>(count);
    std::vector<std::uint32_t> best_order = members;
    std::size_t best_count = min_left;
    double smallest = std::numeric_limits<double>::infinity();
    std::vector<std::pair<double, std::uint32_t>> keyed(count);
    std::vector<Ball> sorted(count);
    std::vector<double> left_min(count + 1), right_min(count + 1);  // lower bounds of the radii around the first and the last members
    for (int key = 0; key < 5; ++key) {
      for (std::size_t i = 0; i < count; ++i) {
        const Ball& b = children_[members[i]];
        keyed[i] = {key < 3 ? b.centre[key] : key == 3 ? b.radius : (b.centre - middle).norm(), members[i]};
      }
      std::sort(keyed.begin(), keyed.end());
      Eigen::AlignedBox3d box;
      for (std::size_t i = 0; i < count; ++i) {
        sorted[i] = children_[keyed[i].second];
        extendBy(sorted[i], box);
        left_min[i + 1] = 0.5 * box.sizes().maxCoeff();
      }
      box.setEmpty();
      for (std::size_t i = count; i-- > 0;) {
        extendBy(sorted[i], box);
        right_min[i] = 0.5 * box.sizes().maxCoeff();
      }
      const std::size_t step = std::max<std::size_t>(1, (max_left - min_left) / kCuts);
      for (std::size_t here = min_left; here <= max_left; here += step) {
        if (here == 0 || here == count) continue;
        if (cost(here, left_min[here]) + cost(count - here, right_min[here]) >= smallest) continue;
        const std::span<const Ball> all(sorted);
        const double sum = cost(here, enclosing(all.first(here)).radius) + cost(count - here, enclosing(all.subspan(here)).radius);
        if (sum >= smallest) continue;
        smallest = sum;
        best_count = here;
        for (std::size_t i = 0; i < count; ++i) best_order[i] = keyed[i].second;
      }
    }
    members = best_order;
    return best_count;
  }

  // Assigns the groups to the parents: greedily, the largest parents first (`anew`), then by exchanges. Returns false
  // if nothing changed.
  bool matchParents(bool anew) {
    for (Group& g : groups_) g.inner = boundOf(kNone, g.members);
    const auto price = [&](const Group& g, std::uint32_t parent) {
      if (parent == kNone) return cost(g.members.size(), g.inner.radius);
      return g.members.empty() ? parents_[parent].radius : cost(g.members.size(), jointRadius(g.inner, parents_[parent]));
    };
    if (anew) {
      std::vector<std::uint32_t> by_size(parents_.size());
      std::iota(by_size.begin(), by_size.end(), 0u);
      std::stable_sort(by_size.begin(), by_size.end(),
                       [&](std::uint32_t x, std::uint32_t y) { return parents_[x].radius > parents_[y].radius; });
      for (const std::uint32_t p : by_size) {
        Group* best = nullptr;
        double smallest = std::numeric_limits<double>::infinity();
        for (Group& g : groups_) {
          if (g.parent != kNone) continue;
          const double more = price(g, p) - price(g, kNone);
          if (!best || more < smallest) smallest = more, best = &g;
        }
        best->parent = p;
      }
    }
    bool any = false;
    for (int pass = 0, changed = 1; pass < kPasses && changed; ++pass) {
      changed = 0;
      for (std::size_t i = 0; i < groups_.size(); ++i)
        for (std::size_t j = i + 1; j < groups_.size(); ++j) {
          Group &a = groups_[i], &b = groups_[j];
          const double now = price(a, a.parent) + price(b, b.parent);
          if (price(a, b.parent) + price(b, a.parent) < now * (1 - kWorthwhile))
            std::swap(a.parent, b.parent), a.changed = b.changed = pass_, changed = 1;
        }
      any = any || changed;
    }
    return any;
  }

  // A parent without a child takes the nearest child whose group has others.
  void fillEmpty() {
    for (std::uint32_t g = 0; g < groups_.size(); ++g) {
      if (!groups_[g].members.empty() || groups_[g].parent == kNone) continue;
      std::uint32_t best = kNone;
      double smallest = std::numeric_limits<double>::infinity();
      for (std::uint32_t c = 0; c < children_.size(); ++c) {
        const double distance = (children_[c].centre - parents_[groups_[g].parent].centre).norm();
        if (groups_[group_of_[c]].members.size() > 1 && distance < smallest) smallest = distance, best = c;
      }
      if (best == kNone) return;
      std::erase(groups_[group_of_[best]].members, best);
      groups_[g].members.push_back(best);
      group_of_[best] = g;
    }
  }

  // One pass of moves and swaps of children between near groups of which one has changed since the last pass. Returns
  // false if nothing improved.
  bool exchangeChildren() {
    bool any = false;
    std::vector<std::pair<double, std::uint32_t>> near(groups_.size());
    ++pass_;
    for (std::uint32_t c = 0; c < children_.size(); ++c) {
      const std::uint32_t a = group_of_[c];
      if (groups_[a].members.size() < 2) continue;
      for (std::uint32_t g = 0; g < groups_.size(); ++g)
        near[g] = {(children_[c].centre - groups_[g].inner.centre).norm() - groups_[g].inner.radius, g};
      const std::size_t kept = std::min(near.size(), kNeighbours);
      std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(kept), near.end());
      int changed = groups_[a].changed;
      for (std::size_t i = 0; i < kept; ++i) changed = std::max(changed, groups_[near[i].second].changed);
      if (changed + 1 >= pass_) any = exchangeOne(c, {near.data(), kept}) || any;
    }
    return any;
  }

  // Makes the best move or swap of a child into one of the given groups, if it lowers the cost.
  bool exchangeOne(std::uint32_t c, std::span<const std::pair<double, std::uint32_t>> near) {
    const std::uint32_t a = group_of_[c];
    Group& from = groups_[a];
    std::vector<std::uint32_t> without = from.members;
    std::erase(without, c);
    const double radius_without = std::min(from.bound.radius, boundOf(from.parent, without).radius);
    const double cost_moved = cost(without.size(), radius_without), cost_swapped = cost(from.members.size(), radius_without);
    const bool is_outer = cost_swapped < cost(from) * (1 - kWorthwhile);  // swapping any other child would not improve its group
    double best_gain = kWorthwhile * cost(from);
    std::uint32_t best_group = a, best_other = kNone;
    std::vector<std::uint32_t> with;
    for (const auto& [distance, b] : near) {
      if (b == a) continue;
      const Group& to = groups_[b];
      const double before = cost(from) + cost(to);
      const double joint = minRadius(to, c, kNone);
      if (to.members.size() < capacity_ && before - cost_moved - cost(to.members.size() + 1, joint) > best_gain) {
        with = to.members;
        with.push_back(c);
        const double gain = before - cost_moved - cost(with.size(), boundOf(to.parent, with).radius);
        if (gain > best_gain) best_gain = gain, best_group = b, best_other = kNone;
      }
      for (std::size_t i = 0; is_outer && i < to.members.size(); ++i) {
        const std::uint32_t other = to.members[i];
        if (before - cost_swapped - cost(to.members.size(), minRadius(to, c, other)) <= best_gain) continue;
        with = without;
        with.push_back(other);
        const double cost_a = cost(with.size(), boundOf(from.parent, with).radius);
        if (before - cost_a <= best_gain) continue;
        with = to.members;
        with[i] = c;
        const double gain = before - cost_a - cost(with.size(), boundOf(to.parent, with).radius);
        if (gain > best_gain) best_gain = gain, best_group = b, best_other = other;
      }
    }
    if (best_group == a) return false;
    Group& to = groups_[best_group];
    from.members = std::move(without);
    if (best_other != kNone) {
      std::erase(to.members, best_other);
      from.members.push_back(best_other);
      group_of_[best_other] = a;
    }
    to.members.push_back(c);
    group_of_[c] = best_group;
    for (Group* g : {&from, &to}) {
      g->bound = boundOf(g->parent, g->members);
      g->inner = boundOf(kNone, g->members);
      g->changed = pass_;
    }
    return true;
  }

  // A lower bound of the radius around a group with one more child and, optionally, without another one.
  double minRadius(const Group& group, std::uint32_t more, std::uint32_t less) const {
    double radius = group.parent == kNone ? 0 : jointRadius(children_[more], parents_[group.parent]);
    for (const std::uint32_t c : group.members)
      if (c != less) radius = std::max(radius, jointRadius(children_[more], children_[c]));
    return radius;
  }

  const std::vector<Ball>& parents_;
  const std::vector<Ball>& children_;
  std::size_t capacity_;
  std::vector<Group> groups_;
  std::vector<std::uint32_t> group_of_;  // (children)
  int pass_ = 0;
  mutable std::vector<Ball> scratch_;
};

struct GroupedLevels {
  std::vector<std::vector<Sphere>> levels;
  std::vector<std::vector<std::uint32_t>> parents;
  double cost = 0;
};

GroupedLevels group(std::vector<std::vector<Sphere>> levels, std::span<const std::size_t> parent_count, std::size_t branching,
                    SpareParents spare) {
  GroupedLevels out{std::move(levels), {}, 0};
  out.parents.resize(out.levels.size());
  if (out.levels.empty()) return out;
  // Scales by a power of two to about the same size: a cube root does not round equally at all scales, and two choices
  // may have the same cost.
  int exponent = 0;
  std::frexp(out.levels[0].empty() ? 1.0f : out.levels[0][0].radius, &exponent);
  const double scale = std::ldexp(1.0, -exponent);
  std::vector<Ball> below;
  for (const Sphere& s : out.levels.back()) below.push_back(scaledBall(s, scale));
  for (std::size_t level = out.levels.size(); level-- > 1;) {
    std::vector<Sphere>& owners = out.levels[level - 1];
    const std::size_t parents = parent_count.empty() ? owners.size() : std::min(owners.size(), parent_count[level - 1]);
    std::size_t groups = parents;
    if (level > 1) groups = std::max(groups, (below.size() + branching - 1) / branching);
    if (level > 1 && spare == SpareParents::Fill)
      groups = std::max(groups, std::min(out.levels[level - 2].size() * branching, below.size()));
    if (below.size() > groups * branching)
      throw std::invalid_argument("hierarchy: level " + std::to_string(level) + " has more spheres than its parents may have children");
    std::vector<Ball> above;
    for (std::size_t i = 0; i < parents; ++i) above.push_back(scaledBall(owners[i], scale));
    const Grouping grouping(above, below, branching, groups);
    std::vector<Ball> bounds;
    for (const Sphere& s : owners) bounds.push_back(scaledBall(s, scale));
    out.parents[level].resize(below.size());
    for (const Grouping::Group& g : grouping.groups()) {
      std::uint32_t parent = g.parent;
      if (parent == kNone) {
        parent = static_cast<std::uint32_t>(owners.size());
        owners.push_back(out.levels[level][g.members[0]]);
        bounds.emplace_back();
      }
      bounds[parent] = g.bound;
      out.cost += Grouping::cost(g);
      for (const std::uint32_t c : g.members) out.parents[level][c] = parent;
    }
    below = std::move(bounds);
  }
  return out;
}

}  // namespace

std::vector<std::vector<std::uint32_t>> groupLevels(std::vector<std::vector<Sphere>>& levels, int branching, SpareParents spare,
                                                    std::span<const std::size_t> parent_count) {
  const auto full = static_cast<std::size_t>(branching);
  GroupedLevels best = group(levels, parent_count, full, spare);
  bool fits = true;  // no further nodes are needed
  for (std::size_t level = 1; level < levels.size(); ++level) fits = fits && levels[level].size() <= levels[level - 1].size() * full;
  if (fits && best.levels != levels) {  // more groups also cost more tests
    GroupedLevels plain = group(levels, parent_count, full, SpareParents::Omit);
    if (plain.cost <= best.cost) best = std::move(plain);
  }
  levels = std::move(best.levels);
  return best.parents;
}

std::vector<std::size_t> levelCounts(std::size_t leaves, int branching) {
  const auto full = static_cast<std::size_t>(branching);
  std::vector<std::size_t> largest{1};  // for each level
  while (largest.back() < leaves) largest.push_back(largest.back() * full);
  std::vector<std::size_t> counts(largest.size(), leaves);
  for (std::size_t level = counts.size() - 1; level-- > 0;)
    counts[level] = std::min(largest[level], (4 * counts[level + 1] + 3 * full - 1) / (3 * full));
  return counts;
}

}  // namespace spheretree::builder
