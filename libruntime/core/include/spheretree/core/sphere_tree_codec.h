// SPDX-License-Identifier: Apache-2.0
// The bytes of a .stree file, in memory: encode and decode side by side. The layout: docs/file_format.md
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "spheretree/core/file_format.h"
#include "spheretree/core/sphere_tree.h"

namespace spheretree {

/// What a status means and what to do about it, as one sentence.
std::string_view explain(LoadStatus status);

/// The bytes of a tree file. decodeSphereTree(encodeSphereTree(t)) == t, bit for bit.
/// @throws std::invalid_argument for a tree in which findFault() finds a fault.
std::vector<std::byte> encodeSphereTree(const SphereTree& tree);

/// Checks everything: a decoded tree is sound (findFault). Unknown optional sections are skipped. `tree` changes only
/// if the status is Ok. Allocates in proportion to the size of `bytes`, which need no alignment. `fault`, if given,
/// receives the place and the values. Cost: about 0.2 ms for 512 leaves with a search tree and a skin of 4,000
/// triangles.
[[nodiscard]] LoadStatus decodeSphereTree(std::span<const std::byte> bytes, SphereTree& tree, std::string* fault = nullptr) noexcept;

}  // namespace spheretree
