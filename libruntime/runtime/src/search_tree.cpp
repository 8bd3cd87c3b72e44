// SPDX-License-Identifier: Apache-2.0
#include "search_tree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace spheretree::runtime {
namespace {

constexpr std::size_t kChildren = 8;
constexpr int kRounds = 2;                // of taking each node out and putting it in again; a third changes the cost by 1 %
constexpr int kMostLooks = 1000;          // for the best place of a node; 30 are usual
constexpr std::size_t kManyNodes = 8191;  // that 16 bits can name
constexpr std::uint32_t kNone = 0xffffffffu;

Eigen::Vector3d centreOf(const Sphere& s) { return {s.x, s.y, s.z}; }

/// How far spheres reach along eight directions and against them: nearly as tight as the smallest ball, and two are joined at once.
class Kdop {
 public:
  Kdop() = default;
  explicit Kdop(const Sphere& s) {
    constexpr float d = 0.57735027f;  // the axes and the diagonals of a cube; the first axis twice
    const Eigen::Array<float, 8, 1> along{
        s.x, s.y, s.z, d * (s.x + s.y + s.z), d * (s.x + s.y - s.z), d * (s.x - s.y + s.z), d * (s.x - s.y - s.z), s.x};
    reach_ << s.radius + along, s.radius - along;
  }
  Kdop join(const Kdop& e) const {
    Kdop both;
    both.reach_ = reach_.max(e.reach_);
    return both;
  }
  /// Of the ball about it, but for a factor.
  float area() const {
    const float width = (reach_.head<8>() + reach_.tail<8>()).maxCoeff();
    return width * width;
  }
  bool operator==(const Kdop& e) const { return (reach_ == e.reach_).all(); }

 private:
  Eigen::Array<float, 16, 1> reach_;
};

/// A binary tree over the leaves whose inner nodes have little area in sum: a node is met as often as its area says.
/// Nodes [0, leaves) are the leaves, the others have two parts.
class BinaryTree {
 public:
  explicit BinaryTree(std::span<const Sphere> leaves) : leaves_(leaves) {
    for (const Sphere& s : leaves) nodes_.push_back({Kdop(s)});
    nodes_.reserve(2 * leaves.size());
    std::vector<std::uint32_t> all(leaves.size());
    std::iota(all.begin(), all.end(), 0u);
    root_ = halve(all);
    for (std::uint32_t n = 0; n < nodes_.size(); ++n) nodes_[n].area = nodes_[n].extent.area();
    for (int round = 0; round < kRounds; ++round)
      for (std::uint32_t n = 0; n < nodes_.size(); ++n) placeAnew(n);
  }

  std::size_t size() const { return nodes_.size(); }
  std::uint32_t root() const { return root_; }
  bool isLeaf(std::uint32_t n) const { return n < leaves_.size(); }
  const std::array<std::uint32_t, 2>& parts(std::uint32_t n) const { return nodes_[n].part; }
  float width(std::uint32_t n) const { return std::sqrt(nodes_[n].area); }

 private:
  struct Node {
    Kdop extent;
    float area = 0;
    std::uint32_t parent = kNone;
    std::array<std::uint32_t, 2> part{kNone, kNone};
  };

  // A first tree: halves along the longest side.
  std::uint32_t halve(std::span<std::uint32_t> leaves) {
    if (leaves.size() == 1) return leaves[0];
    Eigen::AlignedBox3d box;
    for (const std::uint32_t i : leaves) box.extend(centreOf(leaves_[i]));
    int axis = 0;
    box.sizes().maxCoeff(&axis);
    const std::size_t half = leaves.size() / 2;
    std::nth_element(leaves.begin(), leaves.begin() + static_cast<std::ptrdiff_t>(half), leaves.end(),
                     [&](std::uint32_t a, std::uint32_t b) {
                       return std::pair(centreOf(leaves_[a])[axis], a) < std::pair(centreOf(leaves_[b])[axis], b);
                     });
    const std::array<std::uint32_t, 2> part{halve(leaves.first(half)), halve(leaves.subspan(half))};
    const auto n = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back({nodes_[part[0]].extent.join(nodes_[part[1]].extent), 0, kNone, part});
    for (const std::uint32_t p : part) nodes_[p].parent = n;
    return n;
  }

  // Takes a node out, with its parent, and puts both in where they add least area; where they were if nowhere is better.
  void placeAnew(std::uint32_t n) {
    const std::uint32_t parent = nodes_[n].parent;
    if (parent == kNone || nodes_[parent].parent == kNone) return;
    const std::uint32_t sibling = nodes_[parent].part[nodes_[parent].part[0] == n];
    hang(sibling, nodes_[parent].parent, parent);
    const float saved = nodes_[parent].area + update(nodes_[sibling].parent);
    const std::uint32_t at = bestPlace(n, sibling, saved);
    hang(parent, nodes_[at].parent, at);
    nodes_[parent].part = {at, n};
    nodes_[at].parent = parent;
    nodes_[parent].extent = nodes_[at].extent.join(nodes_[n].extent);
    nodes_[parent].area = nodes_[parent].extent.area();
    update(nodes_[parent].parent);
  }

  // `n` takes the place of `before` below `parent`.
  void hang(std::uint32_t n, std::uint32_t parent, std::uint32_t before) {
    nodes_[n].parent = parent;
    if (parent == kNone)
      root_ = n;
    else
      nodes_[parent].part[nodes_[parent].part[1] == before] = n;
  }

  // Extents from `n` upwards, after its parts have changed; returns by how much the area fell.
  float update(std::uint32_t n) {
    float fell = 0;
    for (; n != kNone; n = nodes_[n].parent) {
      Node& node = nodes_[n];
      const Kdop extent = nodes_[node.part[0]].extent.join(nodes_[node.part[1]].extent);
      if (extent == node.extent) break;
      node.extent = extent;
      fell += node.area;
      node.area = extent.area();
      fell -= node.area;
    }
    return fell;
  }

  // The node beside which `n` adds least area, less than `most`; `otherwise` if there is none.
  std::uint32_t bestPlace(std::uint32_t n, std::uint32_t otherwise, float most) {
    const Node& node = nodes_[n];
    std::uint32_t best = otherwise;
    float least = most * (1 - 1e-5f);
    open_.assign(1, {root_, 0});
    for (int looks = 0; looks < kMostLooks && !open_.empty(); ++looks) {
      const auto [at, above] = open_.back();  // what all nodes above gain, if it goes down to here
      open_.pop_back();
      if (above + node.area >= least) continue;
      const float both = nodes_[at].extent.join(node.extent).area();
      if (above + both < least) {
        least = above + both;
        best = at;
      }
      if (isLeaf(at)) continue;
      const float below = above + both - nodes_[at].area;
      if (below + node.area < least)
        for (const std::uint32_t p : nodes_[at].part) open_.push_back({p, below});
    }
    return best;
  }

  std::span<const Sphere> leaves_;
  std::vector<Node> nodes_;
  std::uint32_t root_ = 0;
  std::vector<std::pair<std::uint32_t, float>> open_;
};

/// Which nodes of a binary tree become nodes of up to 8 children, so that the tests cost least. A node is met as often as its area says
/// with the size of a leaf about it: what it meets is no point, and small nodes are met by whatever is near. Opened, it costs one for each
/// child and one for the block.
class WideBvhBuilder {
 public:
  explicit WideBvhBuilder(const BinaryTree& tree) : tree_(tree), choices_(tree.size()) {
    std::uint32_t leaves = 0;
    for (; leaves < tree.size() && tree.isLeaf(leaves); ++leaves) leaf_width_ += tree.width(leaves);
    leaf_width_ /= static_cast<float>(leaves);
    std::vector<std::uint32_t> order{tree.root()};  // parents first
    for (std::size_t i = 0; i < order.size(); ++i)
      if (!tree.isLeaf(order[i])) order.insert(order.end(), tree.parts(order[i]).begin(), tree.parts(order[i]).end());
    for (std::size_t i = order.size(); i-- > 0;)
      if (!tree.isLeaf(order[i])) choose(order[i]);
  }

  std::vector<std::uint32_t> childrenOf(std::uint32_t n) const {
    std::vector<std::uint32_t> children;
    std::vector<std::pair<std::uint32_t, std::size_t>> open;
    const auto split = [&](std::uint32_t m, std::size_t lanes) {
      const std::size_t first = choices_[m].first[lanes];
      open.emplace_back(tree_.parts(m)[1], lanes - first);
      open.emplace_back(tree_.parts(m)[0], first);
    };
    split(n, choices_[n].children);
    while (!open.empty()) {
      auto [m, lanes] = open.back();
      open.pop_back();
      const std::array<float, kChildren + 1>& cost = choices_[m].cost;
      while (lanes > 1 && cost[lanes] == cost[lanes - 1]) --lanes;
      if (lanes == 1)
        children.push_back(m);
      else
        split(m, lanes);
    }
    std::stable_partition(children.begin(), children.end(), [&](std::uint32_t m) { return !tree_.isLeaf(m); });
    return children;
  }

 private:
  struct Choice {
    std::array<float, kChildren + 1> cost{};          // (lanes) least of what is tested below, if up to so many lanes stand for the node
    std::array<std::uint8_t, kChildren + 1> first{};  // (lanes) how many of them go to the first part, if the node is not one of them
    std::uint8_t children = 2;                        // if the node is one
  };

  void choose(std::uint32_t n) {
    Choice& choice = choices_[n];
    const Choice &a = choices_[tree_.parts(n)[0]], &b = choices_[tree_.parts(n)[1]];
    // Where names could run short, the fewest nodes count: at least four of the binary tree's make one.
    const bool many = tree_.size() / 2 > kManyNodes;
    const float width = tree_.width(n) + leaf_width_;
    const auto opened = [&](std::size_t lanes) { return many ? 1 : width * width * static_cast<float>(1 + lanes); };
    std::array<float, kChildren + 1> split;
    choice.cost[1] = std::numeric_limits<float>::infinity();
    for (std::size_t lanes = 2; lanes <= kChildren; ++lanes) {
      split[lanes] = std::numeric_limits<float>::infinity();
      choice.first[lanes] = 1;  // stays where sizes are beyond float
      for (std::size_t first = 1; first < lanes; ++first)
        if (const float sum = a.cost[first] + b.cost[lanes - first]; sum < split[lanes]) {
          split[lanes] = sum;
          choice.first[lanes] = static_cast<std::uint8_t>(first);
        }
      if (const float whole = split[lanes] + opened(lanes); whole < choice.cost[1]) {
        choice.cost[1] = whole;
        choice.children = static_cast<std::uint8_t>(lanes);
      }
    }
    for (std::size_t lanes = 2; lanes <= kChildren; ++lanes) choice.cost[lanes] = std::min(choice.cost[lanes - 1], split[lanes]);
  }

  const BinaryTree& tree_;
  float leaf_width_ = 0;  // mean
  std::vector<Choice> choices_;
};

Sphere ballAbout(std::uint32_t node, const BinaryTree& tree, std::span<const Sphere> leaves) {
  std::vector<Sphere> below;
  std::vector<std::uint32_t> open{node};
  while (!open.empty()) {
    const std::uint32_t n = open.back();
    open.pop_back();
    if (tree.isLeaf(n))
      below.push_back(leaves[n]);
    else
      open.insert(open.end(), tree.parts(n).begin(), tree.parts(n).end());
  }
  return smallestEnclosing(below);
}

}  // namespace

std::vector<SearchNode> makeSearchTree(std::span<const Sphere> leaves) {
  const BinaryTree tree(leaves);
  const WideBvhBuilder widening(tree);
  std::vector<std::uint32_t> order{tree.root()};
  std::vector<SearchNode> nodes;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::uint32_t n = order[i];
    if (tree.isLeaf(n)) {
      nodes.push_back({leaves[n], n});
      continue;
    }
    const std::vector<std::uint32_t> children = widening.childrenOf(n);
    nodes.push_back(
        {ballAbout(n, tree, leaves), kNotALeaf, static_cast<std::uint32_t>(order.size()), static_cast<std::uint32_t>(children.size())});
    order.insert(order.end(), children.begin(), children.end());
  }
  return nodes;
}

}  // namespace spheretree::runtime
