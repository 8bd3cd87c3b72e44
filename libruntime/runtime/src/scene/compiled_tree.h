// SPDX-License-Identifier: Apache-2.0
// A search tree (core/search_tree.h) in the memory layout of the search: the children of an inner node are in one
// 128-byte block of 8 lanes, so that one sphere is tested against all of them at once. A node is identified by its slot
// = 8 * block + lane; the root is slot 0, alone in block 0. Empty lanes are far away.
// Units: mm; frame: axes of the file, origin at a given centre.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "spheretree/core/search_tree.h"
#include "spheretree/core/sphere_tree.h"

namespace spheretree::runtime {

struct alignas(128) Block {
  float x[8], y[8], z[8], r[8];
};
static_assert(sizeof(Block) == 128);

/// Lanes [0, inner) of a block are inner nodes; the others are items or empty. The children of lane k are in block
/// first_child + k.
struct BlockLinks {
  std::uint16_t first_child = 0, inner = 0;
  float open_priority[8] =
      {};  // (lane) of inner nodes: radius / number of children [mm]; of two nodes, the one with the larger value is opened first
};

inline constexpr std::uint32_t kNoItem = 0xffffffffu;
inline constexpr float kFarAway = 1e18f;  // an empty lane; its squared distance still fits a float

struct CompiledTree {
  std::vector<Block> bound;                  // spheres that the search tests: of items, or bounding spheres of inner nodes
  std::vector<Sphere> spheres;               // (slot) the same spheres as array of structures
  std::vector<BlockLinks> links;             // (block)
  std::vector<std::array<double, 3>> exact;  // (slot) centre before rounding to float
  std::vector<std::uint32_t> item;           // (slot) kNoItem for an inner node or an empty lane
  double reach = 0;                          // no point of an item's sphere is farther than this from the frame's origin [mm]
  float smallest_radius = 0;                 // of the items' spheres [mm]

  bool isInner(std::size_t slot) const { return slot % 8 < links[slot / 8].inner; }
  std::size_t byteCount() const;
};

/// For a tree over triangles, `spheres` and `exact` stay empty: rows are made from the triangles, and only the
/// published algorithm, which uses leaves, needs exact pairs.
enum class TreeOver { Leaves, Triangles };

/// `items`: the sphere of each item. `origin`: origin of the spheres' frame minus the centre of the compiled tree.
CompiledTree compileTree(const SearchTree& search, std::span<const Sphere> items, const Eigen::Vector3d& origin, TreeOver over);

/// The tree's search tree over its leaves, that is over levelSet() of the deepest level. If the file has none: its own
/// inner nodes with their bounding spheres, which is slower to search and finds the same pairs.
SearchTree searchTreeOf(const SphereTree& tree);

/// A block without nodes; and put(), which writes a node to a lane of it.
Block emptyBlock();
void put(Block& block, std::size_t lane, const Eigen::Vector3d& centre, float radius);

}  // namespace spheretree::runtime
