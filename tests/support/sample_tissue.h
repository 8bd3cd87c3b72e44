// SPDX-License-Identifier: Apache-2.0
// Small tissue for tests of core: two tetrahedra.
#pragma once

#include "spheretree/core/tissue.h"
#include "support/sample_skins.h"
#include "support/sample_trees.h"

namespace spheretree::test {

/// A tree with a skin, such as that of tissue.
inline SphereTree softTree() { return withSkin(withSearch(threeLevelTree(), 2), boxSkin({1, 2, 3})); }

/// With the leaves of `tree`, and the vertices of its skin; their pieces and bindings are invented.
inline Tissue twoTetrahedra(const SphereTree& tree) {
  Tissue tissue;
  tissue.material = {15, 0.45, 1040};
  tissue.nodes = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  tissue.tetrahedra = {{0, 1, 2, 3}, {1, 2, 3, 4}};
  tissue.fixed = {0, 2};
  tissue.surface = {{{0, 0, 0}, 0, {1, 0, 0}}, {{0.5, 0.5, 0.5}, 1, {0.25f, 0.25f, 0.25f}}, {{1, 1, 1}, 1, {0, 0, 0}}};
  tissue.leaves.cuts = {{{0, 1, 2}, 0, {0.25, 0.5}}, {{2, 0, 1}, 0, {0.125, 0.375}}};
  tissue.leaves.begin = {0};
  const auto leaves = static_cast<std::uint32_t>(levelSet(tree, tree.levelCount() - 1).size());
  for (std::uint32_t leaf = 0; leaf < leaves; ++leaf) {
    tissue.leaves.anchors.push_back({{0, 1, 2}, {0.25f, 0.5f}, leaf % 2, {0.5f, 0.25f, -1}, 0.125f * static_cast<float>(leaf)});
    for (std::uint32_t k = 0; k <= leaf % 3; ++k) tissue.leaves.corners.push_back((leaf + k) % 5);
    tissue.leaves.begin.push_back(static_cast<std::uint32_t>(tissue.leaves.corners.size()));
  }
  tissue.response.pressed = {1, 3};
  for (std::uint32_t v = 0; v < tree.skin.vertices.size() + tree.skin.edges.size(); ++v)
    tissue.response.points.push_back({{v % 2, kNone, 1}, {0.25f, 0.5f, 0.25f}});
  for (std::size_t i = 0; i < 9 * 2 * 2; ++i) tissue.response.matrix.push_back(static_cast<float>(i) / 8);
  return tissue;
}

}  // namespace spheretree::test
