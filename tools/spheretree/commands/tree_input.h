// SPDX-License-Identifier: GPL-3.0-or-later
// Trees as verbs read them: what a file holds is told by the ending of its name.
#pragma once

#include <filesystem>
#include <string>

#include "spheretree/core/sphere_tree.h"

namespace spheretree::tool {

/// A tree from .stree, .sph or .json; standard input ("-") is told by its content. @throws UsageError for another
/// ending, and what the readers throw.
SphereTree readTree(const std::filesystem::path& path);

}  // namespace spheretree::tool
