// SPDX-License-Identifier: GPL-3.0-or-later
// Soft tissue in a scene: makes tetrahedra for its objects, and trees that move with them.
#pragma once

#include <vector>

#include "pipeline/batch/batch_items.h"

namespace spheretree::pipeline {

/// Prefix of notes about tissue.
inline constexpr const char* kSoftNote = "soft: ";

/// Gives each item that is soft tissue, and that has a tree, its `soft` bytes (core's tissue_codec.h), from the cache
/// or newly computed, and adds a note about them to its figures. If that is impossible, the item gets the status
/// Failed. Items are processed one after the other: the child process with TetGen uses one core, everything else all
/// cores.
/// @throws builder::Cancelled; formats::FileError if the cache is not writable.
void softenItems(std::vector<BatchItem>& items, const TreeCache& cache, builder::Progress& progress);

}  // namespace spheretree::pipeline
