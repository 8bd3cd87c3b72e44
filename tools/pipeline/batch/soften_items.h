// SPDX-License-Identifier: GPL-3.0-or-later
// The objects of a scene that are soft tissue: tetrahedra, and trees that move with them.
#pragma once

#include <vector>

#include "pipeline/batch/batch_items.h"

namespace spheretree::pipeline {

/// What a note about tissue begins with.
inline constexpr const char* kSoftNote = "soft: ";

/// Gives each item that the scene calls soft, and that has a tree, its `soft` bytes (core's tissue_codec.h) from the
/// cache, or makes them, and adds a note about them to its figures. An item that cannot be softened has failed. They
/// are made one after the other: the child of TetGen takes one core, the rest uses all.
/// @throws builder::Cancelled; formats::FileError if the cache cannot be written to.
void softenItems(std::vector<BatchItem>& items, const TreeCache& cache, builder::Progress& progress);

}  // namespace spheretree::pipeline
