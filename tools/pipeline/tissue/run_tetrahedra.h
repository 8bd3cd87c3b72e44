// SPDX-License-Identifier: GPL-3.0-or-later
// Runs the program spheretree-tetrahedra (TetGen, AGPL) as a child: files in, files out, a time limit.
#pragma once

#include <filesystem>

#include "spheretree/builder/progress.h"
#include "spheretree/builder/soften_tree.h"

namespace spheretree::pipeline {

/// Where the child is: what the environment variable SPHERETREE_TETRAHEDRA names, else beside this program, else in
/// PATH.
std::filesystem::path tetrahedraProgram();

/// Tetrahedra of at most `max_volume` [mm^3] that fill `surface`, which is closed and does not cross itself. The child
/// is killed after `seconds`, and when `progress` is cancelled.
/// @throws builder::BuildError with the reason: it is not installed, gives up, crashes, takes too long, or writes what
/// cannot be read; builder::Cancelled; formats::FileError if the files between the two cannot be written.
TetrahedronList runTetrahedra(const TriangleMesh& surface, double max_volume, double seconds, builder::Progress& progress);

}  // namespace spheretree::pipeline
