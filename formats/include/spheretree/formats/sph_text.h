// SPDX-License-Identifier: Apache-2.0
// The .sph text of the Sphere-Tree Construction Toolkit, which many planners read. docs/file_format.md
#pragma once

#include <string>
#include <string_view>

#include "spheretree/core/sphere_tree.h"

namespace spheretree::formats {

/// First line `LEVELS BRANCHING`, then `x y z r importance` for every slot of the full tree: children of slot n are
/// n*B+1 .. n*B+B, radius -1 for an unused slot. Centres in the frame of the mesh [mm], 9 significant digits;
/// importance 1 (unused: 0).
/// `kind`: which spheres of the inner nodes are written. Cost: O(branching^levels), at most 37,449 lines.
std::string writeSph(const SphereTree& tree, SphereKind kind);

/// The text's spheres become cover spheres, rounded to float; bounding spheres are computed. Nothing is known of the
/// mesh, so that overhang bounds are kUnproven. Siblings keep their order, but inner ones come first. Columns after the
/// radius and lines after the last slot are ignored, since the toolkit writes more there. `name` stands in front of
/// messages.
/// @throws FormatError, with the line: LEVELS not within 1 to 6, BRANCHING not within 2 to 8, too few lines, a number
/// that is none or not finite, radius 0, an unused root, a used slot below an unused one.
SphereTree parseSph(std::string_view text, const std::string& name);

}  // namespace spheretree::formats
