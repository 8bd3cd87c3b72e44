// SPDX-License-Identifier: Apache-2.0
// The bytes of a .soft file: a .stree file with additional sections for the tissue. A reader of .stree files that does
// not know tissue skips them and reads the tree at rest. The layout: docs/file_format.md
#pragma once

#include "spheretree/core/sphere_tree_codec.h"
#include "spheretree/core/tissue.h"

namespace spheretree {

/// The bytes of a tree with its tissue. decodeSoftTree() restores both, bit for bit.
/// @throws std::invalid_argument for a tree or a tissue in which findFault() finds a fault.
std::vector<std::byte> encodeSoftTree(const SphereTree& tree, const Tissue& tissue);

/// Checks everything, as decodeSphereTree() does. A file without tissue is Ok and empties `tissue`. `tree` and `tissue`
/// change only if the status is Ok.
[[nodiscard]] LoadStatus decodeSoftTree(std::span<const std::byte> bytes, SphereTree& tree, Tissue& tissue,
                                        std::string* fault = nullptr) noexcept;

}  // namespace spheretree
