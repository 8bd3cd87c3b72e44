// SPDX-License-Identifier: GPL-3.0-or-later
#include "tree/promote_leaves.h"

#include <algorithm>
#include <limits>
#include <tuple>

#include "certify/redundant_spheres.h"
#include "spheretree/core/none.h"

namespace spheretree::builder {

namespace {

// For each sphere the leaf outside of which it protrudes least, unless that leaf is taken; spheres that protrude least
// choose first.
std::vector<std::uint32_t> standIns(const std::vector<Sphere>& spheres, const std::vector<Sphere>& leaves) {
  struct Pair {
    double out;
    std::uint32_t sphere, leaf;
  };
  std::vector<Pair> pairs;
  for (std::uint32_t i = 0; i < spheres.size(); ++i) {
    Pair best{std::numeric_limits<double>::infinity(), i, kNone};
    for (std::uint32_t c = 0; c < leaves.size(); ++c) {
      const double out = (centreOf(spheres[i]) - centreOf(leaves[c])).norm() + spheres[i].radius - leaves[c].radius;
      if (out < best.out) best.out = out, best.leaf = c;
    }
    pairs.push_back(best);
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return std::tie(a.out, a.sphere) < std::tie(b.out, b.sphere); });
  std::vector<char> is_taken(leaves.size(), 0);
  std::vector<std::uint32_t> leaf(spheres.size(), kNone);
  for (const Pair& p : pairs)
    if (!is_taken[p.leaf]) leaf[p.sphere] = p.leaf, is_taken[p.leaf] = 1;
  return leaf;
}

// How many spheres a level has once each level above has enough parents for the one below (hierarchy.h).
std::size_t grownCount(const std::vector<std::vector<Sphere>>& levels, std::size_t level, std::size_t full) {
  std::size_t count = 0;
  for (std::size_t below = levels.size(); below-- > level;) count = std::max(levels[below].size(), (count + full - 1) / full);
  return count;
}

}  // namespace

std::vector<std::size_t> promoteLeaves(const TriangleMesh& mesh, const Eigen::Vector3d& origin, int branching, std::uint64_t seed,
                                       std::vector<std::vector<Sphere>>& levels, Progress& progress) {
  std::vector<std::size_t> parent_count;
  for (const auto& level : levels) parent_count.push_back(level.size());
  const auto full = static_cast<std::size_t>(branching);
  std::vector<Sphere> ended;  // leaves of levels above the current one
  for (std::size_t level = 1; level + 1 < levels.size(); ++level) {
    std::vector<Sphere>&own = levels[level], &leaves = levels.back();
    // A sphere that becomes a leaf removes the capacity for its children, and just above the leaves one child, too.
    const std::size_t room = own.size() * full, children = grownCount(levels, level + 1, full),
                      takes = level + 2 == levels.size() ? full - 1 : full;
    const std::size_t largest = std::min({room > children ? (room - children) / takes : 0, own.size() - 1, leaves.size() - 1});
    if (largest == 0) continue;
    std::vector<std::uint32_t> leaf = standIns(own, leaves);
    // First finds the spheres that are redundant if the leaves of all spheres are added; then, among these, those that
    // are redundant if only their own leaves are added; and so on.
    for (std::size_t tried = own.size() + 1, wanted = own.size(); wanted < tried && wanted > 0;) {
      tried = wanted;
      std::vector<Sphere> set = own;
      std::vector<char> fixed;
      for (const std::uint32_t c : leaf) fixed.push_back(c == kNone);
      for (const std::uint32_t c : leaf)
        if (c != kNone) set.push_back(leaves[c]);
      set.insert(set.end(), ended.begin(), ended.end());
      fixed.resize(set.size(), 1);
      const std::vector<std::uint32_t> one_group(set.size(), 0);
      const std::vector<char> redundant = findRedundantSpheres(mesh, set, origin, one_group, fixed, largest, seed, progress);
      wanted = 0;
      for (std::size_t i = 0; i < own.size(); ++i) {
        if (!redundant[i]) leaf[i] = kNone;
        wanted += leaf[i] != kNone;
      }
    }
    std::vector<Sphere> first, last, left;
    std::vector<char> is_moved(leaves.size(), 0);
    for (std::size_t i = 0; i < own.size(); ++i) {
      if (leaf[i] == kNone) first.push_back(own[i]);
      if (leaf[i] != kNone) last.push_back(leaves[leaf[i]]), is_moved[leaf[i]] = 1;
    }
    for (std::size_t c = 0; c < leaves.size(); ++c)
      if (!is_moved[c]) left.push_back(leaves[c]);
    parent_count[level] = first.size();
    own = std::move(first);
    own.insert(own.end(), last.begin(), last.end());
    ended.insert(ended.end(), last.begin(), last.end());
    leaves = std::move(left);
  }
  if (!levels.empty()) parent_count.back() = levels.back().size();
  return parent_count;
}

}  // namespace spheretree::builder
