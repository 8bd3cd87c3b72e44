// SPDX-License-Identifier: Apache-2.0
// The .sph text format of the Sphere-Tree Construction Toolkit, which many planners read. docs/file_format.md
#pragma once

#include <string>
#include <string_view>

#include "spheretree/core/sphere_tree.h"

namespace spheretree::formats {

/// First line `LEVELS BRANCHING`, then `x y z r importance` for every slot of the full tree. The children of slot n are
/// n*B+1 .. n*B+B; an unused slot has the radius -1. Centres in the frame of the mesh [mm], 9 significant digits;
/// importance 1 (unused: 0).
/// `kind`: which spheres of the inner nodes are written. Cost: O(branching^levels), at most 37,449 lines.
std::string writeSph(const SphereTree& tree, SphereKind kind);

/// The spheres of the text become cover spheres, rounded to float; bounding spheres are computed. Overhang bounds are
/// kUnproven, because the mesh is unknown. Siblings keep their order, except that inner nodes come first. Columns after
/// the radius and lines after the last slot are ignored, since the toolkit writes additional ones. `name` is the prefix
/// of messages.
/// @throws FormatError, with the line: LEVELS not within 1 to 6, BRANCHING not within 2 to 8, too few lines, a field
/// that is not a finite number, radius 0, an unused root, a used slot below an unused one.
SphereTree parseSph(std::string_view text, const std::string& name);

}  // namespace spheretree::formats
