// SPDX-License-Identifier: Apache-2.0
#include "search_tree_spheres.h"

#include "describe.h"

namespace spheretree {

std::string describeSphereFault(std::size_t node, std::size_t item) {
  if (item == kNone) return describe("sphere %zu of the search tree is not finite, or its radius is not above 0", node);
  return describe("sphere %zu of the search tree does not enclose item %zu", node, item);
}

}  // namespace spheretree
