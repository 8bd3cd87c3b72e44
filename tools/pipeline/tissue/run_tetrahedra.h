// SPDX-License-Identifier: GPL-3.0-or-later
// Runs the program spheretree-tetrahedra (TetGen, AGPL) as a child process, with input and output files and a time
// limit.
#pragma once

#include <filesystem>

#include "spheretree/builder/progress.h"
#include "spheretree/builder/soften_tree.h"

namespace spheretree::pipeline {

/// The path of the child program: from the environment variable SPHERETREE_TETRAHEDRA, otherwise beside this program,
/// otherwise from PATH.
std::filesystem::path tetrahedraProgram();

/// Tetrahedra of at most `max_volume` [mm^3] that fill `surface`, which must be closed and free of self-intersections.
/// The child is killed after `seconds`, and when `progress` is cancelled.
/// @throws builder::BuildError with the reason: the child is not installed, gives up, crashes, takes too long, or
/// writes an invalid file; builder::Cancelled; formats::FileError if the exchanged files cannot be written.
TetrahedronList runTetrahedra(const TriangleMesh& surface, double max_volume, double seconds, builder::Progress& progress);

}  // namespace spheretree::pipeline
