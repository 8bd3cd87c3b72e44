// SPDX-License-Identifier: Apache-2.0
// The sphere-tree: two spheres for an inner node, one for a leaf.
//
// Every node has a *cover sphere*. The cover spheres of a level, together with the leaves of earlier levels, cover the
// whole surface of the object. Every inner node also has a *bounding sphere*, which encloses its own cover sphere and
// those of all its descendants. A traversal tests bounding spheres, so that it misses no pair, whichever level it stops
// at.
// Units: mm. Frame: that of the input mesh, moved by -origin_mm (zero unless the mesh lies far from the origin of its
// frame).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "spheretree/core/hulls.h"
#include "spheretree/core/none.h"
#include "spheretree/core/search_tree.h"
#include "spheretree/core/skin.h"
#include "spheretree/core/sphere.h"

namespace spheretree {

inline constexpr int kMinLevels = 2, kMaxLevels = 6;        // the root is level 0
inline constexpr int kMinBranching = 2, kMaxBranching = 8;  // children of an inner node
inline constexpr std::uint32_t kMaxNodes = 37449;           // a full tree of 6 levels and branching 8
inline constexpr float kUnproven = -1;                      // in place of an overhang bound

using Hash128 = std::array<std::uint8_t, 16>;

/// 32 lower-case hexadecimal digits.
std::string toHex(const Hash128& hash);

/// What the builder proved or measured about the level set of one level. Lengths in mm.
struct LevelStatistics {
  std::uint32_t sphere_count = 0;    // size of the level set: nodes of the level and leaves of earlier ones
  float overhang_bound = kUnproven;  // proven: no cover sphere of the level set reaches farther out of the object
  float smallest_radius = 0;
  float largest_radius = 0;
  friend bool operator==(const LevelStatistics&, const LevelStatistics&) = default;
};

/// Where a tree comes from. Stored in the file; nothing in here depends on the machine, the clock or the thread count.
struct Provenance {
  std::string builder;     // "cover", "merge", ... at most 15 bytes
  std::string quality;     // "quick", "standard", "best"; at most 15 bytes
  std::string generator;   // "spheretree 1.2.3"; at most 31 bytes
  double unit_mm = 1;      // length of one unit of the source file [mm]
  double diagonal_mm = 0;  // of the bounding box of the mesh
  double volume_mm3 = 0;   // enclosed by the mesh
  double area_mm2 = 0;
  double tolerance_mm = 0;     // the requested tolerance; 0: none, the builder used all the leaves it was allowed
  float work_overhang_mm = 0;  // > 0, proven: leaves reach out farther than this only where the tolerances of triangles allow more
  std::uint64_t triangle_count = 0;
  std::uint64_t seed = 0;
  Hash128 mesh_hash{};      // XXH3-128 of positions [mm, doubles] and triangles, as the builder received them
  Hash128 settings_hash{};  // XXH3-128 of the settings' text form
  friend bool operator==(const Provenance&, const Provenance&) = default;
};

/// Nodes are stored breadth first. The children of a node are consecutive: first those that have children, then the
/// leaves.
struct SphereTree {
  std::uint8_t branching = 8;               // largest number of children of a node
  std::array<double, 3> origin_mm{};        // add to a centre to get the frame of the mesh
  std::vector<Sphere> cover;                // (node_count)
  std::vector<Sphere> bound;                // (inner_count), in the order of the inner nodes
  std::vector<std::uint32_t> bound_index;   // (node_count) index into `bound`; kNone for a leaf
  std::vector<std::uint32_t> first_child;   // (node_count) > own index; 0 for a leaf
  std::vector<std::uint8_t> child_count;    // (node_count) 0 for a leaf
  std::vector<std::uint32_t> level_begin;   // (level_count + 1) first node of each level, then node_count
  std::vector<LevelStatistics> statistics;  // (level_count)
  Provenance provenance;
  SearchTree search;  // over the leaves, that is levelSet() of the deepest level; empty: none
  Skin skin;          // the surface that a tool rests on; empty: none, and the tool rests on the leaves
  Hulls hulls;        // of a tool: what rests on other surfaces; empty: the leaves do

  std::size_t nodeCount() const { return cover.size(); }
  int levelCount() const { return static_cast<int>(level_begin.size()) - 1; }
  bool isLeaf(std::size_t node) const { return child_count[node] == 0; }
  friend bool operator==(const SphereTree&, const SphereTree&) = default;
};

/// Selects one of the two spheres of an inner node; a leaf has only its cover sphere.
enum class SphereKind { Cover, Bound };

inline const Sphere& sphereOf(const SphereTree& tree, std::size_t node, SphereKind kind) {
  return kind == SphereKind::Cover || tree.isLeaf(node) ? tree.cover[node] : tree.bound[tree.bound_index[node]];
}

/// Nodes of the level set of `level` (0 .. levelCount() - 1): the nodes of that level and the leaves of earlier levels,
/// in file order. Cost: O(nodes).
std::vector<std::uint32_t> levelSet(const SphereTree& tree, int level);

/// Fills first_child, bound_index and level_begin from `child_count` (node_count values). Returns false, and leaves the
/// tree unusable, if the counts do not describe one tree of at most kMaxLevels levels, breadth first, with inner
/// siblings ahead of leaves. Cost: O(nodes).
[[nodiscard]] bool linkNodes(SphereTree& tree);

/// Fills `bound` from `cover` and a topology that linkNodes() accepted: smallestEnclosing() of the cover spheres of
/// each node and all its descendants. Cost: O(nodes * levels), times about 10.
void encloseDescendants(SphereTree& tree);

/// Sets sphere_count, smallest_radius and largest_radius of every level from the cover spheres. Keeps overhang bounds;
/// those of new levels are kUnproven. Cost: O(nodes * levels).
void countLevels(SphereTree& tree);

/// Returns a sentence about the first broken invariant, which names the node and the values, or "" for a sound tree.
/// Enclosure is evaluated in double precision on the stored floats, with no tolerance. Cost: O(nodes * levels). Checks
/// that
/// - array sizes and topology are right (breadth first, consecutive, in range, no cycle);
/// - centres are finite, and radii finite and > 0;
/// - every bounding sphere encloses its own cover sphere and all cover spheres below it;
/// - the statistics agree with the spheres, and the provenance fits its fields in the file;
/// - every sphere of the search tree encloses the leaves below it, and findFault() of the skin and of the hulls finds
///   nothing.
std::string findFault(const SphereTree& tree);

}  // namespace spheretree
