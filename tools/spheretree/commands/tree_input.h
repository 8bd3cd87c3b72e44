// SPDX-License-Identifier: GPL-3.0-or-later
// Trees as verbs read them: what a file holds is told by the ending of its name.
#pragma once

#include <filesystem>
#include <string>

#include "spheretree/core/sphere_tree.h"
#include "spheretree/core/tissue.h"

namespace spheretree::tool {

/// A tree from .stree, .sph or .json; standard input ("-") is told by its content. @throws UsageError for another
/// ending, and what the readers throw.
SphereTree readTree(const std::filesystem::path& path);

/// A tree with its tissue, from .soft. @throws UsageError for another ending or a file without tissue, and what the
/// readers throw.
SphereTree readSoftTree(const std::filesystem::path& path, Tissue& tissue);

}  // namespace spheretree::tool
