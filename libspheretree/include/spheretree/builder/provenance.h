// SPDX-License-Identifier: GPL-3.0-or-later
// Hashes of the mesh and the settings of a tree. They are stored with the tree and show whether it still belongs to its
// mesh and settings. XXH3-128 in canonical (big-endian) byte order: the same on every machine. They do not protect
// against forgery.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "spheretree/builder/build_settings.h"
#include "spheretree/core/sphere_tree.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// Hash of any bytes.
Hash128 bytesHash(std::span<const std::byte> bytes);

/// Hash of positions [mm, doubles] and triangles in their order, without parts and their names. Cost: O(size of the
/// mesh).
Hash128 meshHash(const TriangleMesh& mesh);

/// The settings as text, one `name=value` a line, with exact numbers; settingsHash() hashes it. It leaves out
/// `threads`, on which the result does not depend, and `unit_mm`, which is already applied to the mesh.
std::string settingsText(const BuildSettings& settings);

Hash128 settingsHash(const BuildSettings& settings);

}  // namespace spheretree::builder
