// SPDX-License-Identifier: Apache-2.0
// A sphere-tree as JSON, schema "spheretree.tree/1": without loss, both ways. docs/file_format.md
#pragma once

#include <string>
#include <string_view>

#include "spheretree/core/sphere_tree.h"

namespace spheretree::formats {

/// parseTreeJson(writeTreeJson(t)) == t, bit for bit, with search tree and skin. One node a line. Lengths in mm.
std::string writeTreeJson(const SphereTree& tree);

/// `schema`, `branching` and `nodes` with `cover` and `child_count` are needed, and nodes breadth first with inner
/// siblings ahead of leaves. Bounding spheres that are absent from all nodes, and statistics that are absent, are
/// computed; `provenance`, `origin_mm`, `search` and `skin` may be absent. Numbers are rounded to float where the tree
/// stores floats. `name` stands in front of messages.
/// @throws FormatError with the place in the text or the path of the element.
SphereTree parseTreeJson(std::string_view text, const std::string& name);

}  // namespace spheretree::formats
