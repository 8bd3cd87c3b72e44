// SPDX-License-Identifier: Apache-2.0
// The bytes of a .soft file: a .stree file with sections for the tissue behind those of the tree. A reader of .stree
// files that does not know tissue skips them and gets the tree at rest. The layout: docs/file_format.md
#pragma once

#include "spheretree/core/sphere_tree_codec.h"
#include "spheretree/core/tissue.h"

namespace spheretree {

/// Bytes of a tree with its tissue. Decoding them gives both back, bit for bit.
/// @throws std::invalid_argument for a tree or a tissue in which findFault() finds a fault.
std::vector<std::byte> encodeSoftTree(const SphereTree& tree, const Tissue& tissue);

/// Checks everything, as decodeSphereTree() does. A file without tissue is Ok and leaves `tissue` empty. Both are
/// changed only by Ok.
[[nodiscard]] LoadStatus decodeSoftTree(std::span<const std::byte> bytes, SphereTree& tree, Tissue& tissue,
                                        std::string* fault = nullptr) noexcept;

}  // namespace spheretree
