// SPDX-License-Identifier: GPL-3.0-or-later
// Which components of a mesh lie within which: by exact winding numbers.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct Enclosure {
  std::uint32_t component;
  int winding;  // of that component round the one asked for
};

/// `first_triangle`: (components) one triangle of each. For each component those that enclose it. A component that
/// crosses others is in none: it has no one place. The mesh must be closed.
std::vector<std::vector<Enclosure>> findEnclosures(const TriangleMesh& mesh, std::span<const std::uint32_t> component_of,
                                                   std::span<const std::uint32_t> first_triangle, const std::vector<bool>& crosses_other);

}  // namespace spheretree::builder
