// SPDX-License-Identifier: Apache-2.0
// Checks that the inner spheres of a search tree enclose the items below them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "sphere_checks.h"
#include "spheretree/core/none.h"
#include "spheretree/core/rounding.h"
#include "spheretree/core/search_tree.h"

namespace spheretree {

/// The sentence about inner sphere `node`, which does not enclose `item`, or is not finite itself (kNone).
std::string describeSphereFault(std::size_t node, std::size_t item);

/// Returns a sentence about the first inner sphere that is not finite, whose radius is not above 0, or that does not
/// enclose an item below it; "" if there is none. `encloses(sphere, item)` tells whether a sphere encloses an item. The
/// topology must be sound (findTopologyFault).
/// Cost: usually 2 to 3 calls of `encloses` for each item, at most one for each item and each level above it.
template <class Encloses>
std::string findSphereFault(const SearchTree& tree, const Encloses& encloses) {
  // If a child sphere lies this far inside, it encloses everything below it on behalf of its parent, since that is
  // checked against the child itself: the rounding errors of both checks (8 roundings to 2^-53 of the radius) cannot
  // add up to more.
  const std::size_t inner = tree.inner.size();
  std::vector<std::uint32_t> first_inner(inner), first_item(inner);
  for (std::uint32_t i = 0, next_inner = 1, next_item = 0; i < inner; ++i) {
    if (!isFinite(tree.inner[i])) return describeSphereFault(i, kNone);
    first_inner[i] = next_inner, first_item[i] = next_item;
    next_inner += tree.inner_children[i], next_item += tree.item_children[i];
  }
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < inner; ++i) {
    const Sphere& sphere = tree.inner[i];
    open.assign(1, i);
    while (!open.empty()) {
      const std::size_t node = open.back();
      open.pop_back();
      for (std::size_t k = first_item[node]; k < first_item[node] + tree.item_children[node]; ++k)
        if (const std::size_t item = tree.item.empty() ? k : tree.item[k]; !encloses(sphere, item)) return describeSphereFault(i, item);
      for (std::size_t k = first_inner[node]; k < first_inner[node] + tree.inner_children[node]; ++k)
        if (!(reach(sphere, tree.inner[k]) <= static_cast<double>(sphere.radius) * (1 - kRounding))) open.push_back(k);
    }
  }
  return {};
}

}  // namespace spheretree
