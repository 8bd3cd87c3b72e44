// SPDX-License-Identifier: GPL-3.0-or-later
// Fingerprints of what went into a tree, stored with it: whether a tree still fits its mesh and its settings can be
// told from them. XXH3-128 in canonical (big-endian) byte order: the same on every machine. Not a defence against
// forgery.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "spheretree/builder/build_settings.h"
#include "spheretree/core/sphere_tree.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// Of any bytes.
Hash128 bytesHash(std::span<const std::byte> bytes);

/// Of positions [mm, doubles] and triangles, in their order; parts and their names do not count. Cost: O(size of the
/// mesh).
Hash128 meshHash(const TriangleMesh& mesh);

/// The settings as text, one `name=value` a line, numbers without loss; what the hash is taken of. `threads` is left
/// out, since the result does not depend on it, and `unit_mm`, which the mesh has absorbed.
std::string settingsText(const BuildSettings& settings);

Hash128 settingsHash(const BuildSettings& settings);

}  // namespace spheretree::builder
