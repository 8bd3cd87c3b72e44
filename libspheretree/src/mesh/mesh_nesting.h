// SPDX-License-Identifier: GPL-3.0-or-later
// Which components of a mesh lie within which others, by exact winding numbers.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct Enclosure {
  std::uint32_t component;
  int winding;  // winding number of that component around the given one
};

/// Returns for each component the components that enclose it. `first_triangle`: (components) one triangle of each. A
/// component that crosses others has no enclosures, because it is not on one side of them. The mesh must be closed.
std::vector<std::vector<Enclosure>> findEnclosures(const TriangleMesh& mesh, std::span<const std::uint32_t> component_of,
                                                   std::span<const std::uint32_t> first_triangle, const std::vector<bool>& crosses_other,
                                                   const Progress& progress = {});

}  // namespace spheretree::builder
