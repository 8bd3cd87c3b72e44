// SPDX-License-Identifier: GPL-3.0-or-later
#include "skin/build_search_tree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "spheretree/core/smallest_enclosing_ball.h"

namespace spheretree::builder {
namespace {

constexpr int kPlacingRounds = 2;  // rounds in which each node is removed and inserted again; a third round changes the cost by 1 %
constexpr int kMaxLooks = 1000;    // nodes tested for the best place of a node; 30 are usual
constexpr std::uint32_t kNoNode = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t kPoints = 6;  // whose hull contains a patch: three corners, and the control points of three sides

/// Extent of spheres along eight directions, both ways: nearly as tight as the smallest ball, and cheap to merge.
class Kdop {
 public:
  Kdop() = default;
  explicit Kdop(std::span<const Sphere> spheres) {
    reach_.setConstant(-std::numeric_limits<float>::infinity());
    constexpr float d = 0.57735027f;  // the axes and the diagonals of a cube; the first axis twice
    for (const Sphere& s : spheres) {
      const Eigen::Array<float, 8, 1> along{
          s.x, s.y, s.z, d * (s.x + s.y + s.z), d * (s.x + s.y - s.z), d * (s.x - s.y + s.z), d * (s.x - s.y - s.z), s.x};
      reach_.head<8>() = reach_.head<8>().max(s.radius + along);
      reach_.tail<8>() = reach_.tail<8>().max(s.radius - along);
    }
  }
  Kdop join(const Kdop& e) const {
    Kdop both;
    both.reach_ = reach_.max(e.reach_);
    return both;
  }
  /// Surface area of the enclosing ball, up to a constant factor.
  float area() const {
    const float width = (reach_.head<8>() + reach_.tail<8>()).maxCoeff();
    return width * width;
  }
  Eigen::Array3f middle() const { return 0.5f * (reach_.head<3>() - reach_.segment<3>(8)); }
  bool operator==(const Kdop& e) const { return (reach_ == e.reach_).all(); }

 private:
  Eigen::Array<float, 16, 1> reach_;
};

/// A binary tree over the items with a small total area of its inner nodes: the probability that a search visits a node
/// is proportional to its area. Nodes [0, items) are the items; each other node has two children.
class BinaryTree {
 public:
  BinaryTree(std::span<const Sphere> spheres, std::size_t spheres_of_item) : items_(spheres.size() / spheres_of_item) {
    nodes_.reserve(2 * items_);
    for (std::size_t i = 0; i < items_; ++i) nodes_.push_back({Kdop(spheres.subspan(i * spheres_of_item, spheres_of_item))});
    std::vector<std::uint32_t> all(items_);
    std::iota(all.begin(), all.end(), 0u);
    root_ = halve(all);
    for (Node& node : nodes_) node.area = node.extent.area();
    for (int round = 0; round < kPlacingRounds; ++round)
      for (std::uint32_t n = 0; n < nodes_.size(); ++n) placeAnew(n);
  }

  std::size_t size() const { return nodes_.size(); }
  std::size_t items() const { return items_; }
  std::uint32_t root() const { return root_; }
  bool isItem(std::uint32_t n) const { return n < items_; }
  const std::array<std::uint32_t, 2>& parts(std::uint32_t n) const { return nodes_[n].part; }
  float width(std::uint32_t n) const { return std::sqrt(nodes_[n].area); }

 private:
  struct Node {
    Kdop extent;
    float area = 0;
    std::uint32_t parent = kNoNode;
    std::array<std::uint32_t, 2> part{kNoNode, kNoNode};
  };

  // An initial tree, by halving along the longest side.
  std::uint32_t halve(std::span<std::uint32_t> items) {
    if (items.size() == 1) return items[0];
    Eigen::AlignedBox3f box;
    for (const std::uint32_t i : items) box.extend(nodes_[i].extent.middle().matrix());
    int axis = 0;
    box.sizes().maxCoeff(&axis);
    const std::size_t half = items.size() / 2;
    const auto place = [&](std::uint32_t i) { return std::pair(nodes_[i].extent.middle()[axis], i); };
    std::nth_element(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(half), items.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return place(a) < place(b); });
    std::array<std::uint32_t, 2> part{};
    part[0] = halve(items.first(half));
    part[1] = halve(items.subspan(half));
    const auto n = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back({nodes_[part[0]].extent.join(nodes_[part[1]].extent), 0, kNoNode, part});
    for (const std::uint32_t p : part) nodes_[p].parent = n;
    return n;
  }

  // Removes a node together with its parent, and inserts both where they add the least area; at the old place if no
  // other is better.
  void placeAnew(std::uint32_t n) {
    const std::uint32_t parent = nodes_[n].parent;
    if (parent == kNoNode || nodes_[parent].parent == kNoNode) return;
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

  // `n` replaces `before` below `parent`.
  void hang(std::uint32_t n, std::uint32_t parent, std::uint32_t before) {
    nodes_[n].parent = parent;
    if (parent == kNoNode)
      root_ = n;
    else
      nodes_[parent].part[nodes_[parent].part[1] == before] = n;
  }

  // Updates the extents from `n` upwards after its children have changed; returns the decrease of the area.
  float update(std::uint32_t n) {
    float fell = 0;
    for (; n != kNoNode; n = nodes_[n].parent) {
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

  // The node beside which `n` adds the least area, less than `limit`; `otherwise` if there is none.
  std::uint32_t bestPlace(std::uint32_t n, std::uint32_t otherwise, float limit) {
    const Node& node = nodes_[n];
    std::uint32_t best = otherwise;
    float smallest = limit * (1 - 1e-5f);
    open_.assign(1, {root_, 0});
    for (int looks = 0; looks < kMaxLooks && !open_.empty(); ++looks) {
      const auto [at, above] = open_.back();  // increase of area of all nodes above, if `n` is inserted below this node
      open_.pop_back();
      if (above + node.area >= smallest) continue;
      const float both = nodes_[at].extent.join(node.extent).area();
      if (above + both < smallest) {
        smallest = above + both;
        best = at;
      }
      if (isItem(at)) continue;
      const float below = above + both - nodes_[at].area;
      if (below + node.area < smallest)
        for (const std::uint32_t p : nodes_[at].part) open_.push_back({p, below});
    }
    return best;
  }

  std::size_t items_;
  std::vector<Node> nodes_;
  std::uint32_t root_ = 0;
  std::vector<std::pair<std::uint32_t, float>> open_;
};

/// Chooses the nodes of a binary tree that become nodes with up to 8 children, such that the expected number of tests
/// is smallest. The probability of visiting a node is proportional to its area, enlarged by the size of an item, since
/// the other object is not a point. An opened node costs one test for each child and one for the block.
class WideTree {
 public:
  explicit WideTree(const BinaryTree& tree) : tree_(tree), choices_(tree.size()) {
    for (std::uint32_t i = 0; i < tree.items(); ++i) item_width_ += tree.width(i);
    item_width_ /= static_cast<float>(tree.items());
    std::vector<std::uint32_t> order{tree.root()};  // parents first
    for (std::size_t i = 0; i < order.size(); ++i)
      if (!tree.isItem(order[i])) order.insert(order.end(), tree.parts(order[i]).begin(), tree.parts(order[i]).end());
    for (std::size_t i = order.size(); i-- > 0;)
      if (!tree.isItem(order[i])) choose(order[i]);
  }

  std::vector<std::uint32_t> childrenOf(std::uint32_t n) const {
    if (tree_.isItem(n)) return {n};  // the root of a tree with one item
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
      const std::array<float, kSearchBranching + 1>& cost = choices_[m].cost;
      while (lanes > 1 && cost[lanes] == cost[lanes - 1]) --lanes;
      if (lanes == 1)
        children.push_back(m);
      else
        split(m, lanes);
    }
    std::stable_partition(children.begin(), children.end(), [&](std::uint32_t m) { return !tree_.isItem(m); });
    return children;
  }

 private:
  struct Choice {
    std::array<float, kSearchBranching + 1> cost{};  // (lanes) smallest cost below the node if it occupies up to this number of lanes
    std::array<std::uint8_t, kSearchBranching + 1> first{};  // (lanes) lanes of the first child, if the node itself is not a lane
    std::uint8_t children = 2;                               // number of children if the node is one lane
  };

  void choose(std::uint32_t n) {
    Choice& choice = choices_[n];
    const Choice &a = choices_[tree_.parts(n)[0]], &b = choices_[tree_.parts(n)[1]];
    // If there could be too many nodes for 16 bits, the number of nodes is the cost: then at least four binary nodes
    // make one wide node.
    const bool many = tree_.items() > kMaxSearchNodes;
    const float width = tree_.width(n) + item_width_;
    const auto opened = [&](std::size_t lanes) { return many ? 1 : width * width * static_cast<float>(1 + lanes); };
    std::array<float, kSearchBranching + 1> split{};
    choice.cost[1] = std::numeric_limits<float>::infinity();
    for (std::size_t lanes = 2; lanes <= kSearchBranching; ++lanes) {
      split[lanes] = std::numeric_limits<float>::infinity();
      choice.first[lanes] = 1;  // remains if sizes exceed the range of float
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
    for (std::size_t lanes = 2; lanes <= kSearchBranching; ++lanes) choice.cost[lanes] = std::min(choice.cost[lanes - 1], split[lanes]);
  }

  const BinaryTree& tree_;
  float item_width_ = 0;  // mean width of an item
  std::vector<Choice> choices_;
};

// The smallest sphere around the items below a node of the binary tree.
Sphere sphereAbout(std::uint32_t node, const BinaryTree& tree, std::span<const Sphere> spheres, std::size_t spheres_of_item) {
  std::vector<Sphere> below;
  std::vector<std::uint32_t> open{node};
  while (!open.empty()) {
    const std::uint32_t n = open.back();
    open.pop_back();
    if (tree.isItem(n)) {
      const auto own = spheres.subspan(n * spheres_of_item, spheres_of_item);
      below.insert(below.end(), own.begin(), own.end());
    } else {
      open.insert(open.end(), tree.parts(n).begin(), tree.parts(n).end());
    }
  }
  return smallestEnclosing(below);
}

}  // namespace

SearchTree buildSearchTree(std::span<const Sphere> spheres, std::size_t spheres_of_item) {
  const BinaryTree tree(spheres, spheres_of_item);
  const WideTree wide(tree);
  SearchTree search;
  std::vector<std::uint32_t> order{tree.root()};
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::uint32_t n = order[i];
    search.inner.push_back(sphereAbout(n, tree, spheres, spheres_of_item));
    std::uint8_t inner = 0, items = 0;
    for (const std::uint32_t child : wide.childrenOf(n)) {
      if (tree.isItem(child)) {
        search.item.push_back(static_cast<std::uint16_t>(child));
        ++items;
      } else {
        order.push_back(child);
        ++inner;
      }
    }
    search.inner_children.push_back(inner);
    search.item_children.push_back(items);
  }
  return search;
}

void sortForSearch(Skin& skin) {
  std::vector<Sphere> spheres;
  spheres.reserve(kPoints * skin.triangles.size());
  // findFault() computes the control points in double; here they are rounded to float, with an error below the radius
  // that they get.
  const auto add = [&](const Eigen::Vector3f& p, float size) {
    spheres.push_back({p.x(), p.y(), p.z(), 16 * std::numeric_limits<float>::epsilon() * size + std::numeric_limits<float>::min()});
  };
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
    const SkinPatch patch = patchOf(skin, t);
    float size = 0;
    for (const Eigen::Vector3f& p : patch.position) size = std::max(size, p.cwiseAbs().maxCoeff());
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3f &a = patch.position[k], &b = patch.position[(k + 1) % 3];
      add(a, size);
      add(2 * patch.position[3 + k] - 0.5f * (a + b), size);
    }
  }
  skin.search = buildSearchTree(spheres, kPoints);
  std::vector<SkinTriangle> sorted;
  sorted.reserve(skin.triangles.size());
  for (const std::uint16_t t : skin.search.item) sorted.push_back(skin.triangles[t]);
  skin.triangles = std::move(sorted);
  skin.search.item.clear();
}

}  // namespace spheretree::builder
