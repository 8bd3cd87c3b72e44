// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/sphere_tree.h"

#include <algorithm>
#include <cmath>

#include "describe.h"
#include "search_tree_spheres.h"
#include "spheretree/core/smallest_enclosing_ball.h"

namespace spheretree {

std::string toHex(const Hash128& hash) {
  std::string text;
  for (const std::uint8_t byte : hash) text += describe("%02x", unsigned{byte});
  return text;
}

namespace {

/// Calls `visit(first, last)` for the descendants of `node`, including itself, with one range of nodes for each level:
/// in breadth-first order the descendants on one level are consecutive.
template <class Visit>
void forEachRange(const SphereTree& tree, std::uint32_t node, Visit&& visit) {
  std::uint32_t first = node, last = node + 1;
  while (first < last) {
    visit(first, last);
    std::uint32_t next_first = 0, next_last = 0;
    for (std::uint32_t i = first; i < last; ++i) {
      if (tree.child_count[i] == 0) continue;
      if (next_last == 0) next_first = tree.first_child[i];
      next_last = tree.first_child[i] + tree.child_count[i];
    }
    first = next_first, last = next_last;
  }
}

/// The statistics of one level that countLevels() fills.
LevelStatistics countLevel(const SphereTree& tree, int level) {
  const std::uint32_t first = tree.level_begin[static_cast<std::size_t>(level)],
                      last = tree.level_begin[static_cast<std::size_t>(level) + 1];
  LevelStatistics s;
  for (std::uint32_t i = 0; i < last; ++i) {
    if (i < first && !tree.isLeaf(i)) continue;
    const float radius = tree.cover[i].radius;
    s.smallest_radius = s.sphere_count == 0 ? radius : std::min(s.smallest_radius, radius);
    s.largest_radius = s.sphere_count == 0 ? radius : std::max(s.largest_radius, radius);
    ++s.sphere_count;
  }
  return s;
}

/// The fault of the cover or bounding sphere of `node`; "" for a sound one.
std::string faultInSphere(const Sphere& s, std::size_t node, const char* kind) {
  if (isFinite(s)) return "";
  if (!std::isfinite(s.x) || !std::isfinite(s.y) || !std::isfinite(s.z))
    return describe("node %zu%s: centre (%.9g, %.9g, %.9g) is not finite", node, kind, double{s.x}, double{s.y}, double{s.z});
  return describe("node %zu%s: radius %.9g is not finite and above 0", node, kind, double{s.radius});
}

std::string faultInTopology(const SphereTree& tree) {
  const std::size_t n = tree.nodeCount();
  if (n == 0) return "the tree has no nodes";
  if (n > kMaxNodes) return describe("the tree has %zu nodes, more than %u", n, kMaxNodes);
  if (tree.branching < kMinBranching || tree.branching > kMaxBranching)
    return describe("branching %d is not within 2 to 8", tree.branching);
  if (tree.child_count.size() != n || tree.first_child.size() != n || tree.bound_index.size() != n)
    return "the arrays of nodes differ in length";
  for (std::size_t i = 0; i < n; ++i)
    if (tree.child_count[i] > tree.branching)
      return describe("node %zu: %d children are more than the branching %d", i, tree.child_count[i], tree.branching);
  SphereTree expected;
  expected.cover.resize(n);
  expected.child_count = tree.child_count;
  if (!linkNodes(expected)) return "the numbers of children do not make one tree of at most 6 levels, inner siblings ahead of leaves";
  for (std::size_t i = 0; i < n; ++i) {
    if (tree.first_child[i] != expected.first_child[i])
      return describe("node %zu: first child %u, but breadth-first order makes it %u", i, tree.first_child[i], expected.first_child[i]);
    if (tree.bound_index[i] != expected.bound_index[i])
      return describe("node %zu: bounding sphere %u, but the order of the inner nodes makes it %u", i, tree.bound_index[i],
                      expected.bound_index[i]);
  }
  if (tree.level_begin != expected.level_begin) return "the level boundaries do not fit the numbers of children";
  const std::size_t inner = n - static_cast<std::size_t>(std::count(tree.child_count.begin(), tree.child_count.end(), 0));
  if (tree.bound.size() != inner) return describe("%zu bounding spheres for %zu inner nodes", tree.bound.size(), inner);
  return "";
}

std::string faultInSpheres(const SphereTree& tree) {
  for (std::size_t i = 0; i < tree.nodeCount(); ++i) {
    if (std::string fault = faultInSphere(tree.cover[i], i, ""); !fault.empty()) return fault;
    if (tree.isLeaf(i)) continue;
    if (std::string fault = faultInSphere(tree.bound[tree.bound_index[i]], i, ", bounding sphere"); !fault.empty()) return fault;
  }
  for (std::uint32_t i = 0; i < tree.nodeCount(); ++i) {
    if (tree.isLeaf(i)) continue;
    const Sphere& bound = tree.bound[tree.bound_index[i]];
    std::string fault;
    forEachRange(tree, i, [&](std::uint32_t first, std::uint32_t last) {
      for (std::uint32_t k = first; k < last && fault.empty(); ++k)
        if (const double r = reach(bound, tree.cover[k]); !(r <= double{bound.radius}))
          fault =
              describe("node %u: the bounding sphere of radius %.9g does not enclose the cover sphere of node %u, which reaches to %.9g", i,
                       double{bound.radius}, k, r);
    });
    if (!fault.empty()) return fault;
  }
  return "";
}

std::string faultInStatistics(const SphereTree& tree) {
  if (tree.statistics.size() != static_cast<std::size_t>(tree.levelCount()))
    return describe("%zu levels of statistics for %d levels of nodes", tree.statistics.size(), tree.levelCount());
  for (std::size_t level = 0; level < tree.statistics.size(); ++level) {
    const LevelStatistics &found = tree.statistics[level], right = countLevel(tree, static_cast<int>(level));
    if (found.sphere_count != right.sphere_count)
      return describe("statistics of level %zu: %u spheres, but the level set has %u", level, found.sphere_count, right.sphere_count);
    if (found.smallest_radius != right.smallest_radius || found.largest_radius != right.largest_radius)
      return describe("statistics of level %zu: radii from %.9g to %.9g, but the level set has %.9g to %.9g", level,
                      double{found.smallest_radius}, double{found.largest_radius}, double{right.smallest_radius},
                      double{right.largest_radius});
    if (found.overhang_bound != kUnproven && !(std::isfinite(found.overhang_bound) && found.overhang_bound >= 0))
      return describe("statistics of level %zu: overhang bound %.9g is neither finite and >= 0 nor -1 (not proven)", level,
                      double{found.overhang_bound});
  }
  return "";
}

std::string faultInText(const std::string& text, std::size_t max_size, const char* name) {
  if (text.size() > max_size) return describe("the %s's name has %zu characters, more than %zu", name, text.size(), max_size);
  for (const char c : text)
    if (c < 0x20 || c > 0x7e) return describe("the %s's name has a character outside printable ASCII", name);
  return "";
}

std::string faultInProvenance(const SphereTree& tree) {
  const Provenance& p = tree.provenance;
  for (const double x : tree.origin_mm)
    if (!std::isfinite(x)) return "the origin is not finite";
  if (!std::isfinite(p.unit_mm) || !(p.unit_mm > 0)) return describe("the unit %.9g mm is not finite and above 0", p.unit_mm);
  struct Quantity {
    double value;
    const char* name;
  };
  for (const Quantity& q : {Quantity{p.diagonal_mm, "diagonal"}, Quantity{p.volume_mm3, "volume"}, Quantity{p.area_mm2, "area"},
                            Quantity{p.tolerance_mm, "tolerance"}, Quantity{static_cast<double>(p.work_overhang_mm), "overhang at work"}})
    if (!std::isfinite(q.value) || !(q.value >= 0)) return describe("the %s %.9g is not finite and >= 0", q.name, q.value);
  if (std::string fault = faultInText(p.builder, 15, "builder"); !fault.empty()) return fault;
  if (std::string fault = faultInText(p.quality, 15, "quality"); !fault.empty()) return fault;
  return faultInText(p.generator, 31, "generator");
}

std::string faultInSearch(const SphereTree& tree) {
  if (tree.search.empty()) return tree.search == SearchTree{} ? "" : "search over the leaves: there is an order of leaves, but no node";
  const std::vector<std::uint32_t> leaves = levelSet(tree, tree.levelCount() - 1);
  std::string fault = findTopologyFault(tree.search, leaves.size());
  if (fault.empty())
    fault = findSphereFault(tree.search, [&](const Sphere& s, std::size_t leaf) { return reach(s, tree.cover[leaves[leaf]]) <= s.radius; });
  return fault.empty() ? fault : fault.insert(0, "search over the leaves: ");
}

std::string faultInSkin(const SphereTree& tree) {
  if (!tree.skin.empty()) return findFault(tree.skin);
  return tree.skin == Skin{} ? "" : "the skin has no triangles, but something else";
}

std::string faultInHulls(const SphereTree& tree) {
  if (tree.hulls.empty()) return tree.hulls == Hulls{} ? "" : "the hulls have no parts, but something else";
  std::string fault = findFault(tree.hulls);
  return fault.empty() ? fault : fault.insert(0, "hulls: ");
}

}  // namespace

std::vector<std::uint32_t> levelSet(const SphereTree& tree, int level) {
  std::vector<std::uint32_t> nodes;
  const std::uint32_t first = tree.level_begin[static_cast<std::size_t>(level)],
                      last = tree.level_begin[static_cast<std::size_t>(level) + 1];
  for (std::uint32_t i = 0; i < last; ++i)
    if (i >= first || tree.isLeaf(i)) nodes.push_back(i);
  return nodes;
}

bool linkNodes(SphereTree& tree) {
  const std::size_t n = tree.child_count.size();
  tree.first_child.assign(n, 0);
  tree.bound_index.assign(n, kNone);
  tree.level_begin.assign(1, 0);
  if (n == 0 || n > kMaxNodes || n != tree.cover.size()) return false;
  std::uint32_t next_child = 1, next_bound = 0, level_end = 1;
  for (std::uint32_t i = 0; i < n; ++i) {
    if (i == next_child) return false;  // it is not a child of any node
    if (i == level_end) {
      if (tree.level_begin.size() == static_cast<std::size_t>(kMaxLevels)) return false;
      tree.level_begin.push_back(i);
      level_end = next_child;
    }
    const std::uint32_t count = tree.child_count[i];
    if (count == 0) continue;
    if (count > n - next_child) return false;
    for (std::uint32_t c = next_child + 1; c < next_child + count; ++c)
      if (tree.child_count[c] > 0 && tree.child_count[c - 1] == 0) return false;
    tree.first_child[i] = next_child;
    tree.bound_index[i] = next_bound++;
    next_child += count;
  }
  if (next_child != n) return false;
  tree.level_begin.push_back(static_cast<std::uint32_t>(n));
  return true;
}

void encloseDescendants(SphereTree& tree) {
  tree.bound.clear();
  std::vector<Sphere> family;
  for (std::uint32_t i = 0; i < tree.nodeCount(); ++i) {
    if (tree.isLeaf(i)) continue;
    family.clear();
    forEachRange(tree, i, [&](std::uint32_t first, std::uint32_t last) {
      family.insert(family.end(), tree.cover.begin() + first, tree.cover.begin() + last);
    });
    tree.bound.push_back(smallestEnclosing(family));
  }
}

void countLevels(SphereTree& tree) {
  tree.statistics.resize(static_cast<std::size_t>(tree.levelCount()));
  for (std::size_t level = 0; level < tree.statistics.size(); ++level) {
    const float overhang_bound = tree.statistics[level].overhang_bound;
    tree.statistics[level] = countLevel(tree, static_cast<int>(level));
    tree.statistics[level].overhang_bound = overhang_bound;
  }
}

std::string findFault(const SphereTree& tree) {
  if (std::string fault = faultInTopology(tree); !fault.empty()) return fault;
  if (std::string fault = faultInSpheres(tree); !fault.empty()) return fault;
  if (std::string fault = faultInStatistics(tree); !fault.empty()) return fault;
  if (std::string fault = faultInProvenance(tree); !fault.empty()) return fault;
  if (std::string fault = faultInSearch(tree); !fault.empty()) return fault;
  if (std::string fault = faultInSkin(tree); !fault.empty()) return fault;
  return faultInHulls(tree);
}

}  // namespace spheretree
