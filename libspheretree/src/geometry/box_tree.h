// SPDX-License-Identifier: GPL-3.0-or-later
// A hierarchy of axis-aligned boxes, four children wide: the spatial index for distances, unions of balls and samples.
// Immutable after construction, so that any number of threads may search it.
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
  /// Binned surface-area heuristic; O(n log n). Same boxes, same tree. Items are addressed by *slot*, that is their
  /// place in the order of the leaves. Store item data in slot order, so that the items of a leaf are contiguous in
  /// memory.
  explicit BoxTree(std::span<const Eigen::AlignedBox3d> boxes, int leaf_size = 4);

  /// For items that are triangles (corners in slot order, up to four in a leaf). searchNearest() then uses two further
  /// bounds. For each child: a slab perpendicular to the mean normal of its triangles. A patch of a smooth surface is
  /// much thinner than its box, so without slabs a point that is equally far from all parts of a surface, such as the
  /// centre of a ball, would visit most of them. For each triangle of a leaf: its prism, which excludes nearly all
  /// remaining triangles. O(n log n), 80 bytes a triangle.
  void addTriangles(std::span<const std::array<Eigen::Vector3d, 3>> triangles);

  /// order()[slot] is the index of the item in the span given to the constructor.
  const std::vector<std::uint32_t>& order() const { return order_; }

  /// Visits leaves, nearest box first, as long as the squared distance from `p` to a box is below `limit2`, which
  /// `leaf` may lower. Calls `leaf(first_slot, count)`; for triangles with a count of 1. Returns the number of items in
  /// the visited leaves, as a measure of the work.
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
      // Sorts without branches, since branches on distances are mispredicted half of the time. The bit patterns of
      // doubles >= 0 sort like integers; the lowest two bits are replaced by the child's index, which can only lower a
      // distance.
      std::array<std::uint64_t, 4> key;
      for (std::size_t k = 0; k < 4; ++k) key[k] = (std::bit_cast<std::uint64_t>(d2[static_cast<Eigen::Index>(k)]) & ~std::uint64_t{3}) | k;
      const auto sort2 = [&](std::size_t i, std::size_t j) {
        const std::uint64_t low = std::min(key[i], key[j]), high = std::max(key[i], key[j]);
        key[i] = low, key[j] = high;
      };
      sort2(0, 1), sort2(2, 3), sort2(0, 2), sort2(1, 3), sort2(1, 2);
      for (std::size_t i = 4; i-- > 0;) {  // pushes the nearest last, on top
        const std::size_t k = key[i] & 3;
        const double distance2 = std::bit_cast<double>(key[i] & ~std::uint64_t{3});
        stack[top] = {distance2, node.child[k], node.count[k]};
        top += distance2 < limit2;  // never an empty child: its box is infinitely far
      }
    }
    return met;
  }

  /// Visits every leaf whose box has a distance of at most sqrt(`radius2`) from `p`, in a fixed order.
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
  class TriangleBounds;
  static constexpr std::size_t kStack = 256;  // depth is at most 60 (build() balances below that), with three entries a level
  struct Node {
    std::array<Eigen::Array4f, 3> low, high;  // [axis](child), padded by kPadding; an empty child is infinitely far
    std::int32_t child[4];                    // inner: node index; leaf: first slot
    std::int32_t count[4];                    // > 0: leaf with that many items; -1: inner; 0: empty
  };
  struct Slabs {  // low <= normal . p <= high for everything in a child; padded by 8 kPadding
    std::array<Eigen::Array4f, 3> normal;
    Eigen::Array4f low, high;
  };
  struct Prisms {  // of the triangles of a leaf: a slab around each, padded by 8 kPadding, and a wall through each side, perpendicular to
                   // its plane
    Slabs slab;
    std::array<std::array<Eigen::Array4f, 3>, 3> wall;  // normal . p <= high for the whole triangle
    std::array<Eigen::Array4f, 3> high;
  };
  // Boxes are stored in float, relative to the middle of all boxes and scaled by their extent: half the memory, and
  // twice as many numbers in a vector register. No item may be missed through rounding. Outer sides are therefore moved
  // outward by kPadding, which exceeds the rounding error of a point within 8 extents of the middle. For a point
  // farther away the rounding error, also that of the sums, is less than 2^-22 of its distance to any box; kShrink
  // compensates for it. The height of a point across a slab is the sum of three products; its rounding error is less
  // than 3 kPadding or 3 kPadding times the distance to the box, whichever is larger.
  static constexpr double kPadding = 0x1p-20, kShrink = 1 - 0x1p-19;

  Eigen::Array3f local(const Eigen::Vector3d& p) const {  // clamping is safe: it only moves a far point nearer
    return ((p - middle_) * to_local_).array().max(-1e18).min(1e18).cast<float>();
  }
  /// Squared distances to the four boxes, rounded down; infinite for an empty child. Uses Eigen's arrays, since
  /// compilers do not vectorise the plain loop.
  Eigen::Array4d distances(const Node& node, const Eigen::Array3f& p) const {
    return localDistances(node, p).cast<double>() * from_local2_;
  }
  /// Squared distances to the boxes or to the slabs, whichever are larger.
  Eigen::Array4d distances(const Node& node, const Slabs& slabs, const Eigen::Array3f& p) const {
    return localDistances(node, p).max(outside(slabs, p).square()).cast<double>() * from_local2_;
  }
  /// Lower bounds of the squared distances to the triangles of a leaf: across the plane, and within the plane beyond
  /// the farthest wall.
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
  std::vector<Slabs> slabs_;             // (nodes), or empty
  std::vector<Prisms> prisms_;           // (leaves), or empty
  std::vector<std::uint32_t> prism_of_;  // (slots) index of the prism, at the first slot of a leaf
  std::vector<std::uint32_t> order_;
  Eigen::Vector3d middle_ = Eigen::Vector3d::Zero();
  double to_local_ = 0, from_local2_ = 0;
};

}  // namespace spheretree::builder
