// SPDX-License-Identifier: Apache-2.0
// The sphere-tree: two spheres for an inner node, one for a leaf.
//
// Every node has a *cover sphere*: the cover spheres of a level, with the leaves that ended at an earlier level, cover the
// whole surface of the object. Every inner node also has a *bounding sphere*, which encloses its own cover sphere and those
// of all its descendants: what a traversal tests, so that stopping at any level misses no pair.
// Units: mm. Frame: that of the input mesh, moved by -origin_mm (zero unless the mesh lies far from its frame's origin).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "spheretree/core/sphere.h"

namespace spheretree {

inline constexpr int kMinLevels = 2, kMaxLevels = 6;        // the root is level 0
inline constexpr int kMinBranching = 2, kMaxBranching = 8;  // children of an inner node
inline constexpr std::uint32_t kNoBound = 0xffffffffu;

using Hash128 = std::array<std::uint8_t, 16>;

/// What the builder proved or measured about the level set of one level. Lengths in mm.
struct LevelStatistics {
  std::uint32_t sphere_count = 0;   // size of the level set: nodes of the level and leaves of earlier ones
  float overhang_bound = 0;         // no cover sphere of the level set reaches farther out of the object than this; proven
  float smallest_radius = 0;
  float largest_radius = 0;
};

/// Where a tree comes from. Stored in the file; nothing in here depends on the machine, the clock or the thread count.
struct Provenance {
  std::string builder;             // "cover", "merge", ... at most 15 bytes
  std::string quality;             // "quick", "standard", "best"; at most 15 bytes
  std::string generator;           // "spheretree 0.1.0"; at most 31 bytes
  double unit_mm = 1;              // length of one unit of the source file [mm]
  double diagonal_mm = 0;          // of the bounding box of the mesh
  double volume_mm3 = 0;           // enclosed by the mesh
  double area_mm2 = 0;
  double tolerance_mm = 0;         // asked for; 0: none, the whole budget was used
  std::uint64_t triangle_count = 0;
  std::uint64_t seed = 0;
  Hash128 mesh_hash{};             // XXH3-128 of positions [mm, doubles] and triangles as read
  Hash128 settings_hash{};         // XXH3-128 of the settings' text form
};

/// Breadth first; the children of a node are consecutive, those with children of their own first.
struct SphereTree {
  std::uint8_t branching = 8;               // most children of a node
  std::array<double, 3> origin_mm{};        // add to a centre to get the frame of the mesh
  std::vector<Sphere> cover;                // (node_count)
  std::vector<Sphere> bound;                // (inner_count), in the order of the inner nodes
  std::vector<std::uint32_t> bound_index;   // (node_count) index into `bound`; kNoBound for a leaf
  std::vector<std::uint32_t> first_child;   // (node_count) > own index; 0 for a leaf
  std::vector<std::uint8_t> child_count;    // (node_count) 0 for a leaf
  std::vector<std::uint32_t> level_begin;   // (level_count + 1) first node of each level, then node_count
  std::vector<LevelStatistics> statistics;  // (level_count)
  Provenance provenance;

  std::size_t nodeCount() const { return cover.size(); }
  int levelCount() const { return static_cast<int>(level_begin.size()) - 1; }
  bool isLeaf(std::size_t node) const { return child_count[node] == 0; }
};

/// Nodes of the level set of `level`: the nodes of that level and the leaves of earlier levels, in file order.
std::vector<std::uint32_t> levelSet(const SphereTree& tree, int level);

/// First broken invariant as a sentence that names the node and the values, or "" for a sound tree.
/// Checks topology (breadth first, consecutive, in range, no cycle), radii finite and > 0, and that every bounding sphere
/// encloses its own cover sphere, its children's bounding spheres' contents and so all cover spheres below. Evaluated in
/// double on the stored floats, with no tolerance. Cost: O(nodes * levels).
std::string findFault(const SphereTree& tree);

}  // namespace spheretree
