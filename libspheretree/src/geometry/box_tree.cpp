// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/box_tree.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <limits>
#include <numeric>
#include <stdexcept>

namespace spheretree::builder {

namespace {

constexpr int kBins = 16;
constexpr std::size_t kMaxHalvedByCount =
    16;                               // items that are halved by count, since choosing a plane would cost more than searches gain from it
constexpr double kMinReach = 1e-150;  // half of the largest side of all boxes, below which its square would underflow
constexpr std::size_t kMinParallel = 4096;  // items below which threads cost more than they gain
constexpr int kSahDepth = 40;               // below this depth, halves by count: limits the depth to 40 + log2(n) / 2 for any input

double halfArea(const Eigen::AlignedBox3d& box) {
  if (box.isEmpty()) return 0;
  const Eigen::Vector3d s = box.sizes();
  return s.x() * s.y() + s.y() * s.z() + s.z() * s.x();
}

}  // namespace

// Splits ranges of items until they fit into leaves, and makes the nodes. Large ranges are split on all threads; the
// order of the nodes does not depend on it.
class BoxTree::Builder {
  struct Range {
    std::size_t first = 0, last = 0;
    Eigen::AlignedBox3d box;
    std::size_t size() const { return last - first; }
  };

 public:
  Builder(BoxTree& tree, std::span<const Eigen::AlignedBox3d> boxes, std::size_t leaf_size)
      : tree_(tree), order_(tree.order_), boxes_(boxes), leaf_size_(leaf_size) {
    centre_.reserve(boxes.size());
    for (const Eigen::AlignedBox3d& box : boxes) centre_.emplace_back(0.5 * (box.min() + box.max()));
  }

  void run() {
    const Range all = rangeOf(0, boxes_.size());
    tree_.middle_ = all.box.center();
    const double reach = 0.5 * all.box.sizes().maxCoeff();
    tree_.to_local_ = reach > kMinReach ? 1 / reach : 0;  // 0: all boxes are at one point
    tree_.from_local2_ = kShrink * reach * reach;
    tree_.nodes_ = subtree(all, 0);
  }

 private:
  struct Cut {  // items whose centre is in bin `bin` or below along `axis` go to the left
    int axis = -1, bin = 0;
    double cost = std::numeric_limits<double>::infinity();
    Eigen::AlignedBox3d left, right;  // around the items
  };

  Range rangeOf(std::size_t first, std::size_t last) const {
    Range range{first, last, {}};
    for (std::size_t i = first; i < last; ++i) range.box.extend(boxes_[order_[i]]);
    return range;
  }

  static int binOf(double at, double low, double width) { return std::min(kBins - 1, static_cast<int>((at - low) / width * kBins)); }

  // The best cut between the bins along one axis, by the surface-area heuristic.
  Cut cutAlong(int axis, const Range& range, const Eigen::AlignedBox3d& centres) const {
    Cut best;
    const double low = centres.min()[axis], width = centres.max()[axis] - low;
    if (!(width > 0)) return best;
    std::array<Eigen::AlignedBox3d, kBins> bin_box;
    std::array<std::size_t, kBins> bin_count{};
    for (std::size_t i = range.first; i < range.last; ++i) {
      const auto b = static_cast<std::size_t>(binOf(centre_[order_[i]][axis], low, width));
      bin_box[b].extend(boxes_[order_[i]]);
      ++bin_count[b];
    }
    std::array<double, kBins> right_cost{};
    std::array<Eigen::AlignedBox3d, kBins> right;
    std::size_t right_count = 0;
    for (std::size_t b = kBins; b-- > 1;) {
      right[b] = b + 1 < kBins ? right[b + 1].merged(bin_box[b]) : bin_box[b];
      right_count += bin_count[b];
      right_cost[b] = halfArea(right[b]) * static_cast<double>(right_count);
    }
    Eigen::AlignedBox3d left;
    std::size_t left_count = 0;
    for (std::size_t b = 0; b + 1 < kBins; ++b) {
      left.extend(bin_box[b]);
      left_count += bin_count[b];
      if (left_count == 0 || left_count == range.size()) continue;
      const double cost = halfArea(left) * static_cast<double>(left_count) + right_cost[b + 1];
      if (cost < best.cost) best = {axis, static_cast<int>(b), cost, left, right[b + 1]};
    }
    return best;
  }

  std::array<Range, 2> split(const Range& range, int depth) {
    Eigen::AlignedBox3d centres;
    for (std::size_t i = range.first; i < range.last; ++i) centres.extend(centre_[order_[i]]);
    Cut cut;
    if (range.size() > kMaxHalvedByCount && depth < kSahDepth) {
      std::array<Cut, 3> along;
      const auto find = [&](std::size_t axis) { along[axis] = cutAlong(static_cast<int>(axis), range, centres); };
      if (range.size() > kMinParallel)
        tbb::parallel_for(std::size_t{0}, along.size(), find, tbb::simple_partitioner());
      else
        for (std::size_t axis = 0; axis < along.size(); ++axis) find(axis);
      for (const Cut& c : along)
        if (c.cost < cut.cost) cut = c;
    }
    const auto begin = order_.begin() + static_cast<std::ptrdiff_t>(range.first);
    const auto end = order_.begin() + static_cast<std::ptrdiff_t>(range.last);
    if (cut.axis >= 0) {
      const double low = centres.min()[cut.axis], width = centres.max()[cut.axis] - low;
      const auto at =
          std::stable_partition(begin, end, [&](std::uint32_t i) { return binOf(centre_[i][cut.axis], low, width) <= cut.bin; });
      const auto middle = static_cast<std::size_t>(at - order_.begin());
      return {Range{range.first, middle, cut.left}, Range{middle, range.last, cut.right}};
    }
    // Few items, too deep, or all centres equal: halves, so that the depth stays bounded.
    const std::size_t middle = range.first + range.size() / 2;
    int axis = 0;
    centres.sizes().maxCoeff(&axis);
    std::nth_element(begin, order_.begin() + static_cast<std::ptrdiff_t>(middle), end, [&](std::uint32_t a, std::uint32_t b) {
      const double ca = centre_[a][axis], cb = centre_[b][axis];
      return ca != cb ? ca < cb : a < b;
    });
    return {rangeOf(range.first, middle), rangeOf(middle, range.last)};
  }

  // Up to four ranges: splits the largest range that is not a leaf until there are four.
  std::vector<Range> childrenOf(const Range& range, int depth) {
    std::vector<Range> children{range};
    while (children.size() < 4) {
      std::size_t pick = children.size();
      double largest = -1;
      for (std::size_t i = 0; i < children.size(); ++i)
        if (children[i].size() > leaf_size_ && halfArea(children[i].box) > largest) largest = halfArea(children[i].box), pick = i;
      if (pick == children.size()) break;
      const auto halves = split(children[pick], depth);
      children[pick] = halves[0];
      children.push_back(halves[1]);
    }
    return children;
  }

  // The nodes of a range, the root first.
  std::vector<Node> subtree(const Range& range, int depth) {  // NOLINT(misc-no-recursion): kSahDepth limits the depth
    constexpr float kFarAway = std::numeric_limits<float>::infinity();
    const std::vector<Range> children = childrenOf(range, depth);
    std::array<std::vector<Node>, 4> below;
    const auto descend = [&](std::size_t k) {
      if (children[k].size() > leaf_size_) below[k] = subtree(children[k], depth + 1);
    };
    if (range.size() > kMinParallel)
      tbb::parallel_for(std::size_t{0}, children.size(), descend, tbb::simple_partitioner());
    else
      for (std::size_t k = 0; k < children.size(); ++k) descend(k);
    std::vector<Node> nodes(1);
    for (std::size_t k = 0; k < 4; ++k) {
      const bool used = k < children.size();
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<Eigen::Index>(axis);
        const auto column = static_cast<Eigen::Index>(k);
        const auto local = [&](const Eigen::Vector3d& p) { return (p[i] - tree_.middle_[i]) * tree_.to_local_; };
        nodes[0].low[axis][column] = used ? static_cast<float>(local(children[k].box.min()) - kPadding) : kFarAway;
        nodes[0].high[axis][column] = used ? static_cast<float>(local(children[k].box.max()) + kPadding) : kFarAway;
      }
      nodes[0].child[k] = nodes[0].count[k] = 0;
      if (!used) continue;
      if (below[k].empty()) {
        nodes[0].child[k] = static_cast<std::int32_t>(children[k].first);
        nodes[0].count[k] = static_cast<std::int32_t>(children[k].size());
        continue;
      }
      const auto offset = static_cast<std::int32_t>(nodes.size());
      nodes[0].child[k] = offset;
      nodes[0].count[k] = -1;
      for (Node node : below[k]) {
        for (std::size_t c = 0; c < 4; ++c)
          if (node.count[c] < 0) node.child[c] += offset;
        nodes.push_back(node);
      }
      below[k] = {};
    }
    return nodes;
  }

  BoxTree& tree_;
  std::vector<std::uint32_t>& order_;
  std::span<const Eigen::AlignedBox3d> boxes_;
  std::size_t leaf_size_;
  std::vector<Eigen::Vector3d> centre_;  // of each box
};

BoxTree::BoxTree(std::span<const Eigen::AlignedBox3d> boxes, int leaf_size) : order_(boxes.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  if (!boxes.empty()) Builder(*this, boxes, static_cast<std::size_t>(std::max(leaf_size, 1))).run();
}

// Slabs around triangles, and prisms of the triangles of a leaf, in the local frame of a tree.
class BoxTree::TriangleBounds {
  using Vector3d = Eigen::Vector3d;

 public:
  using Triangles = std::span<const std::array<Vector3d, 3>>;

  explicit TriangleBounds(const BoxTree& tree) : tree_(tree) {}

  // Sets slab `k` to the one around `all` that is perpendicular to their mean normal.
  void putSlab(Slabs& slabs, std::size_t k, Triangles all) const { putSlab(slabs, k, meanNormal(all), all); }

  Prisms prismsOf(Triangles leaf) const {
    Prisms prisms;
    for (std::size_t t = 0; t < 4; ++t) {
      const Triangles one = t < leaf.size() ? leaf.subspan(t, 1) : leaf.first(1);
      const Eigen::Vector3f normal = meanNormal(one);
      putSlab(prisms.slab, t, normal, one);
      for (std::size_t side = 0; side < 3; ++side) {
        const Eigen::Vector3f wall = rounded((one[0][(side + 1) % 3] - one[0][side]).cross(normal.cast<double>()) * tree_.to_local_);
        put(prisms.wall[side], t, wall);
        prisms.high[side][static_cast<Eigen::Index>(t)] = static_cast<float>(heightsOf(one, wall).high) + kWide;
      }
    }
    return prisms;
  }

 private:
  static constexpr float kWide = 8 * kPadding;
  struct Heights {
    double low = std::numeric_limits<double>::infinity(), high = -low;
  };

  // Length at most 1, including rounding. Zero if there is no direction: such a slab or wall excludes nothing.
  static Eigen::Vector3f rounded(const Vector3d& direction) { return (direction.stableNormalized() * (1 - kPadding)).cast<float>(); }

  // Direction of the sum of their area vectors.
  Eigen::Vector3f meanNormal(Triangles all) const {
    Vector3d area = Vector3d::Zero();
    for (const auto& [a, b, c] : all) area += Vector3d((b - a) * tree_.to_local_).cross((c - a) * tree_.to_local_);
    return rounded(area);
  }

  Heights heightsOf(Triangles all, const Eigen::Vector3f& normal) const {
    Heights out;
    for (const std::array<Vector3d, 3>& triangle : all)
      for (const Vector3d& corner : triangle) {
        const Vector3d local = (corner - tree_.middle_) * tree_.to_local_;
        const double height = normal.cast<double>().dot(local);
        out.low = std::min(out.low, height), out.high = std::max(out.high, height);
      }
    return out;
  }

  static void put(std::array<Eigen::Array4f, 3>& normals, std::size_t k, const Eigen::Vector3f& normal) {
    for (std::size_t axis = 0; axis < 3; ++axis) normals[axis][static_cast<Eigen::Index>(k)] = normal[static_cast<Eigen::Index>(axis)];
  }

  void putSlab(Slabs& slabs, std::size_t k, const Eigen::Vector3f& normal, Triangles all) const {
    const Heights heights = all.empty() ? Heights{0, 0} : heightsOf(all, normal);
    put(slabs.normal, k, normal);
    slabs.low[static_cast<Eigen::Index>(k)] = static_cast<float>(heights.low) - kWide;
    slabs.high[static_cast<Eigen::Index>(k)] = static_cast<float>(heights.high) + kWide;
  }

  const BoxTree& tree_;
};

void BoxTree::addTriangles(std::span<const std::array<Eigen::Vector3d, 3>> triangles) {
  const TriangleBounds bounds(*this);
  slabs_.resize(nodes_.size());
  prism_of_.assign(triangles.size(), 0);
  struct Slots {
    std::size_t first, last;
  };
  std::vector<Slots> below(nodes_.size());
  const auto slotsOf = [&](const Node& node, std::size_t k) -> Slots {
    const auto child = static_cast<std::size_t>(node.child[k]);
    if (node.count[k] > 0) return {child, child + static_cast<std::size_t>(node.count[k])};
    return node.count[k] < 0 ? below[child] : Slots{0, 0};
  };
  std::vector<Slots> leaves;
  for (std::size_t i = nodes_.size(); i-- > 0;) {  // children follow their parents
    below[i] = {triangles.size(), 0};
    for (std::size_t k = 0; k < 4; ++k) {
      if (nodes_[i].count[k] == 0) continue;
      const Slots slots = slotsOf(nodes_[i], k);
      below[i] = {std::min(below[i].first, slots.first), std::max(below[i].last, slots.last)};
      if (nodes_[i].count[k] < 0) continue;
      if (slots.last - slots.first > 4) throw std::invalid_argument("box tree: more than four triangles in a leaf");
      prism_of_[slots.first] = static_cast<std::uint32_t>(leaves.size());
      leaves.push_back(slots);
    }
  }
  const auto within = [&](const Slots& slots) { return triangles.subspan(slots.first, slots.last - slots.first); };
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, nodes_.size()), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i)
      for (std::size_t k = 0; k < 4; ++k) bounds.putSlab(slabs_[i], k, within(slotsOf(nodes_[i], k)));
  });
  prisms_.resize(leaves.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, leaves.size()), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) prisms_[i] = bounds.prismsOf(within(leaves[i]));
  });
}

}  // namespace spheretree::builder
