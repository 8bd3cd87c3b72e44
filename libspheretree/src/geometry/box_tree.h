// SPDX-License-Identifier: GPL-3.0-or-later
// A hierarchy of axis-aligned boxes, four children wide: the spatial index under distances, unions of balls and
// samples. Immutable after construction, so that any number of threads may search it.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

namespace spheretree::builder {

class BoxTree {
 public:
  BoxTree() = default;
  /// Binned surface-area heuristic; O(n log n). Same boxes, same tree. Items are then addressed by *slot*: their place
  /// in the order of the leaves. Store item data in slot order, so that a leaf is one run of memory.
  explicit BoxTree(std::span<const Eigen::AlignedBox3d> boxes, int leaf_size = 4);

  /// Where the items are triangles (corners, in slot order, up to four in a leaf), searchNearest() then goes by what is
  /// known of them, too: by a slab across the mean normal about those of each child, since a patch of a smooth surface
  /// is much thinner than its box, and a point as far from all parts of a surface as the centre of a ball is would
  /// otherwise see most of them; and in a leaf by the prism of each, which spares nearly all the rest. O(n log n), 80
  /// bytes a triangle.
  void addTriangles(std::span<const std::array<Eigen::Vector3d, 3>> triangles);

  /// order()[slot] is the index of the item in the span given to the constructor.
  const std::vector<std::uint32_t>& order() const { return order_; }

  /// Visits leaves nearest box first, as long as the squared distance from `p` to a box is below `limit2`, which `leaf`
  /// may lower as it goes. `leaf(first_slot, count)`; triangles one by one. How many items the boxes met hold: a
  /// measure of the work.
  template <class Leaf>
  std::size_t searchNearest(const Eigen::Vector3d& p, double& limit2, Leaf&& leaf) const {
    std::size_t met = 0;
    if (nodes_.empty()) return met;
    struct Entry {
      double distance2;
      std::int32_t child, count;  // as in Node
    };
    const Eigen::Array3f at = local(p);
    std::array<Entry, kStack> stack;
    stack[0] = {0.0, 0, -1};
    std::size_t top = 1;
    while (top > 0) {
      const Entry entry = stack[--top];
      if (!(entry.distance2 < limit2)) continue;
      if (entry.count > 0) {
        const auto first = static_cast<std::size_t>(entry.child), count = static_cast<std::size_t>(entry.count);
        met += count;
        if (prisms_.empty()) {
          leaf(first, count);
          continue;
        }
        const Eigen::Array4d d2 = distances(prisms_[prism_of_[first]], at);
        for (std::size_t k = 0; k < count; ++k)
          if (d2[static_cast<Eigen::Index>(k)] < limit2) leaf(first + k, std::size_t{1});
        continue;
      }
      const auto here = static_cast<std::size_t>(entry.child);
      const Node& node = nodes_[here];
      const Eigen::Array4d d2 = slabs_.empty() ? distances(node, at) : distances(node, slabs_[here], at);
      // Sorted without a branch, since branches on distances are guessed wrong half of the time: the bits of doubles >=
      // 0 sort as whole numbers do, and the lowest two, cut off, hold the child. That only lowers a distance.
      std::array<std::uint64_t, 4> key;
      for (std::size_t k = 0; k < 4; ++k) key[k] = (std::bit_cast<std::uint64_t>(d2[static_cast<Eigen::Index>(k)]) & ~std::uint64_t{3}) | k;
      const auto sort2 = [&](std::size_t i, std::size_t j) {
        const std::uint64_t low = std::min(key[i], key[j]), high = std::max(key[i], key[j]);
        key[i] = low, key[j] = high;
      };
      sort2(0, 1), sort2(2, 3), sort2(0, 2), sort2(1, 3), sort2(1, 2);
      for (std::size_t i = 4; i-- > 0;) {  // the nearest comes on top
        const std::size_t k = key[i] & 3;
        const double distance2 = std::bit_cast<double>(key[i] & ~std::uint64_t{3});
        stack[top] = {distance2, node.child[k], node.count[k]};
        top += distance2 < limit2;  // never an empty child: its box is infinitely far
      }
    }
    return met;
  }

  /// Visits every leaf whose box comes within sqrt(`radius2`) of `p` (touching counts), in a fixed order.
  template <class Leaf>
  void searchWithin(const Eigen::Vector3d& p, double radius2, Leaf&& leaf) const {
    if (nodes_.empty()) return;
    const Eigen::Array3f at = local(p);
    std::array<std::int32_t, kStack> stack;
    int top = 0;
    stack[static_cast<std::size_t>(top++)] = 0;
    while (top > 0) {
      const Node& node = nodes_[static_cast<std::size_t>(stack[static_cast<std::size_t>(--top)])];
      const Eigen::Array4d d2 = distances(node, at);
      for (std::size_t k = 0; k < 4; ++k) {
        if (node.count[k] == 0 || !(d2[static_cast<Eigen::Index>(k)] <= radius2)) continue;
        if (node.count[k] > 0)
          leaf(static_cast<std::size_t>(node.child[k]), static_cast<std::size_t>(node.count[k]));
        else
          stack[static_cast<std::size_t>(top++)] = node.child[k];
      }
    }
  }

 private:
  class Builder;
  static constexpr std::size_t kStack = 256;  // depth is at most 60 (build() balances below that), three entries a level
  struct Node {
    std::array<Eigen::Array4f, 3> low, high;  // [axis](child), kPadding outside the boxes; an empty child is infinitely far
    std::int32_t child[4];                    // inner: node index; leaf: first slot
    std::int32_t count[4];                    // > 0: leaf with that many items; -1: inner; 0: empty
  };
  struct Slabs {  // low <= normal . p <= high for all that is in a child; padded by 8 kPadding
    std::array<Eigen::Array4f, 3> normal;
    Eigen::Array4f low, high;
  };
  struct Prisms {  // of the triangles of a leaf: a slab about each, padded by 8 kPadding, and a wall across its plane along each side
    Slabs slab;
    std::array<std::array<Eigen::Array4f, 3>, 3> wall;  // normal . p <= high for all of the triangle
    std::array<Eigen::Array4f, 3> high;
  };
  // Boxes in float, about the middle of all and as a share of their reach: half the memory, twice as many in a vector.
  // That an item is never passed over: outer sides are moved out by kPadding, more than what a point within 8 reaches of
  // the middle is rounded by; one farther away is rounded by less than a 2^-22nd of its distance to any box, and so are
  // the sums, for which kShrink makes up. A height across a slab, the sum of three products, is rounded by less than
  // 3 kPadding, or that share of the distance to the box, the larger of the two counts.
  static constexpr double kPadding = 0x1p-20, kShrink = 1 - 0x1p-19;

  Eigen::Array3f local(const Eigen::Vector3d& p) const {  // nothing is lost by a point that is nearer than in truth
    return ((p - middle_) * to_local_).array().max(-1e18).min(1e18).cast<float>();
  }
  /// Squared distances to the four boxes, at most the true ones, infinite for no box. Eigen's arrays, since compilers
  /// do not vectorise the plain loop.
  Eigen::Array4d distances(const Node& node, const Eigen::Array3f& p) const {
    return localDistances(node, p).cast<double>() * from_local2_;
  }
  /// Or to the slabs, where these are farther.
  Eigen::Array4d distances(const Node& node, const Slabs& slabs, const Eigen::Array3f& p) const {
    return localDistances(node, p).max(outside(slabs, p).square()).cast<double>() * from_local2_;
  }
  /// To the triangles of a leaf, at most: across the plane, and along it beyond the farthest of the walls.
  Eigen::Array4d distances(const Prisms& prisms, const Eigen::Array3f& p) const {
    Eigen::Array4f beyond = Eigen::Array4f::Zero();
    for (std::size_t k = 0; k < 3; ++k) beyond = beyond.max(along(prisms.wall[k], p) - prisms.high[k]);
    return (outside(prisms.slab, p).square() + beyond.square()).cast<double>() * from_local2_;
  }
  static Eigen::Array4f along(const std::array<Eigen::Array4f, 3>& normal, const Eigen::Array3f& p) {
    return normal[0] * p[0] + normal[1] * p[1] + normal[2] * p[2];
  }
  static Eigen::Array4f outside(const Slabs& slabs, const Eigen::Array3f& p) {
    const Eigen::Array4f height = along(slabs.normal, p);
    return (slabs.low - height).max(height - slabs.high).max(0.0f);
  }
  Eigen::Array4f localDistances(const Node& node, const Eigen::Array3f& p) const {
    Eigen::Array4f d2 = Eigen::Array4f::Zero();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float at = p[static_cast<Eigen::Index>(axis)];
      d2 += (node.low[axis] - at).max(at - node.high[axis]).max(0.0f).square();
    }
    return d2;
  }

  std::vector<Node> nodes_;
  std::vector<Slabs> slabs_;             // (nodes), or none
  std::vector<Prisms> prisms_;           // (leaves), or none
  std::vector<std::uint32_t> prism_of_;  // (slots) of the first of a leaf
  std::vector<std::uint32_t> order_;
  Eigen::Vector3d middle_ = Eigen::Vector3d::Zero();
  double to_local_ = 0, from_local2_ = 0;
};

}  // namespace spheretree::builder
