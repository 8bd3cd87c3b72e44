// SPDX-License-Identifier: GPL-3.0-or-later
// Reads trees for the verbs; the extension of a file tells its format.
#pragma once

#include <filesystem>
#include <string>

#include "spheretree/core/sphere_tree.h"
#include "spheretree/core/tissue.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::tool {

/// A tree from .stree, .sph or .json; standard input ("-") is identified by its content. @throws UsageError for another
/// extension, and the exceptions of the readers.
SphereTree readTree(const std::filesystem::path& path);

/// A tree with its tissue, from .soft. @throws UsageError for another extension or a file without tissue, and the
/// exceptions of the readers.
SphereTree readSoftTree(const std::filesystem::path& path, Tissue& tissue);

/// A warning if `tree` names another mesh as the one that it was built from; otherwise "".
std::string otherMeshWarning(const SphereTree& tree, const std::filesystem::path& tree_path, const TriangleMesh& mesh,
                             const std::filesystem::path& mesh_path);

}  // namespace spheretree::tool
