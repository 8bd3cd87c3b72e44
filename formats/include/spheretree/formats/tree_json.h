// SPDX-License-Identifier: Apache-2.0
// A sphere-tree as JSON, schema "spheretree.tree/1": without loss, both ways. docs/file_format.md
#pragma once

#include <string>
#include <string_view>

#include "spheretree/core/sphere_tree.h"

namespace spheretree::formats {

/// parseTreeJson(writeTreeJson(t)) == t, bit for bit, including search tree and skin. One line for each node. Lengths
/// in mm.
std::string writeTreeJson(const SphereTree& tree);

/// Required: `schema`, `branching`, and `nodes` with `cover` and `child_count`, breadth first with inner siblings ahead
/// of leaves. If bounding spheres are absent from all nodes, or statistics are absent, they are computed. `provenance`,
/// `origin_mm`, `search` and `skin` may be absent. Numbers are rounded to float where the tree stores floats. `name` is
/// the prefix of messages.
/// @throws FormatError with the place in the text or the path of the element.
SphereTree parseTreeJson(std::string_view text, const std::string& name);

}  // namespace spheretree::formats
