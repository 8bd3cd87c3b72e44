// SPDX-License-Identifier: Apache-2.0
// Small sound trees for tests.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "spheretree/core/rigid.h"
#include "spheretree/core/sphere_tree.h"
#include "support/random.h"

namespace spheretree::test {

/// A tree with these child counts (breadth first) and random cover spheres. Sound.
inline SphereTree treeOf(std::vector<std::uint8_t> child_count, std::uint64_t seed = 1) {
  Random random(seed);
  SphereTree tree;
  for (std::size_t i = 0; i < child_count.size(); ++i) {
    Sphere s{};
    s.x = static_cast<float>(random.between(-10, 10));
    s.y = static_cast<float>(random.between(-10, 10));
    s.z = static_cast<float>(random.between(-10, 10));
    s.radius = static_cast<float>(random.between(0.1, 5));
    tree.cover.push_back(s);
  }
  tree.child_count = std::move(child_count);
  if (!linkNodes(tree)) return {};
  encloseDescendants(tree);
  countLevels(tree);
  return tree;
}

/// Random child counts: inner siblings ahead of leaves, at most `levels` levels of at most `branching` children.
inline SphereTree randomTree(std::uint64_t seed, int levels, int branching) {
  Random random(seed);
  std::vector<std::uint8_t> counts;
  std::vector<bool> inner{true};  // of the nodes of one level
  for (int level = 0; level < levels; ++level) {
    std::vector<bool> next;
    for (const bool is_inner : inner) {
      if (!is_inner || level + 1 == levels) {
        counts.push_back(0);
        continue;
      }
      const auto count = 1 + random.below(static_cast<std::uint64_t>(branching)), inner_count = random.below(count + 1);
      counts.push_back(static_cast<std::uint8_t>(count));
      for (std::uint64_t c = 0; c < count; ++c) next.push_back(c < inner_count);
    }
    inner = std::move(next);
  }
  SphereTree tree = treeOf(std::move(counts), seed);
  tree.branching = static_cast<std::uint8_t>(branching);
  return tree;
}

/// The leaves of a tree in the order of its search tree.
inline std::vector<Sphere> leavesOf(const SphereTree& tree) {
  std::vector<Sphere> leaves;
  for (const std::uint32_t node : levelSet(tree, tree.levelCount() - 1)) leaves.push_back(tree.cover[node]);
  return leaves;
}

struct PlacedLeaf {
  std::uint32_t node;
  Eigen::Vector3d centre;
  double radius;
};

/// The leaves of a tree whose object is at `pose`, with the point `reference` of the frame of the mesh at its position.
inline std::vector<PlacedLeaf> placedLeaves(const SphereTree& tree, const Configuration& pose, const Eigen::Vector3d& reference) {
  const Eigen::Vector3d origin(tree.origin_mm[0], tree.origin_mm[1], tree.origin_mm[2]);
  std::vector<PlacedLeaf> leaves;
  for (const std::uint32_t node : levelSet(tree, tree.levelCount() - 1)) {
    const Eigen::Vector3d from_reference = centreOf(tree.cover[node]) + origin - reference;
    leaves.push_back({node, pose.orientation.normalized() * from_reference + pose.position, static_cast<double>(tree.cover[node].radius)});
  }
  return leaves;
}

/// Six nodes on three levels, with every field of the provenance set.
inline SphereTree threeLevelTree() {
  SphereTree tree = treeOf({3, 2, 0, 0, 0, 0});
  tree.branching = 3;
  tree.origin_mm = {0.1, -2000.25, 3e-7};
  tree.statistics[1].overhang_bound = 0.125f;
  tree.statistics[2].overhang_bound = 0;
  Provenance& p = tree.provenance;
  p.builder = "cover";
  p.quality = "standard";
  p.generator = "a generator of 31 characters...";
  p.unit_mm = 25.4;
  p.diagonal_mm = 1.0 / 3;
  p.volume_mm3 = 1e12;
  p.area_mm2 = 5e-300;
  p.tolerance_mm = 0.1;
  p.work_overhang_mm = 0.09f;
  p.triangle_count = ~std::uint64_t{0};
  p.seed = std::uint64_t{1} << 63;
  for (std::size_t i = 0; i < 16; ++i) {
    p.mesh_hash[i] = static_cast<std::uint8_t>(17 * i);
    p.settings_hash[i] = static_cast<std::uint8_t>(255 - i);
  }
  return tree;
}

}  // namespace spheretree::test
