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

  // Cheapest pairs first: how far a child sticks out of a parent's own sphere.
  void assignAll() {
    struct Pair {
      double growth;
      std::uint32_t child, parent;
    };
    std::vector<Pair> pairs;
    near_.resize(children_.size());
    for (std::uint32_t c = 0; c < children_.size(); ++c) {
      std::vector<Pair> all;
      for (std::uint32_t p = 0; p < parents_.size(); ++p)
        all.push_back({(children_[c].centre - parents_[p].centre).norm() + children_[c].radius - parents_[p].radius, c, p});
      const std::size_t kept = std::min(all.size(), 2 * kNeighbours);
      const auto less = [](const Pair& a, const Pair& b) { return a.growth != b.growth ? a.growth < b.growth : a.parent < b.parent; };
      std::partial_sort(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(kept), all.end(), less);
      for (std::size_t i = 0; i < std::min(kept, kNeighbours); ++i) near_[c].push_back(all[i].parent);
      pairs.insert(pairs.end(), all.begin(), all.begin() + static_cast<std::ptrdiff_t>(kept));
    }
    std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
      return a.growth != b.growth ? a.growth < b.growth : a.child != b.child ? a.child < b.child : a.parent < b.parent;
    });
    std::vector<char> placed(children_.size(), 0);
    for (const Pair& pair : pairs)
      if (!placed[pair.child] && members_[pair.parent].size() < capacity_) join(pair.child, pair.parent), placed[pair.child] = 1;
    for (std::uint32_t c = 0; c < children_.size(); ++c) {
      if (placed[c]) continue;
      std::uint32_t best = 0;
      double least = std::numeric_limits<double>::infinity();
      for (std::uint32_t p = 0; p < parents_.size(); ++p) {
        if (members_[p].size() == capacity_) continue;
        const double growth = (children_[c].centre - parents_[p].centre).norm() - parents_[p].radius;
        if (growth < least) least = growth, best = p;
      }
      join(c, best);
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
