// SPDX-License-Identifier: GPL-3.0-or-later
// A picture of a sphere-tree for a page or a report: the mesh and every level side by side, with soft shading, as PNG.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "spheretree/core/sphere_tree.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree {

inline constexpr int kMinPictureWidth = 100, kMaxPictureWidth = 3000;  // [pixels]

struct PictureSettings {
  std::array<double, 3> view{1, -2, 1};  // from the object towards the eye, any length > 0; z points up, or y if the view is along z
  int width = 1600;                      // of all panels together [pixels], in [kMinPictureWidth, kMaxPictureWidth]
  int levels = 4;                        // largest number of levels that are drawn, from the root
};

/// PNG with one panel for `mesh` (none if null) and one for each level, all at one scale, in parallel projection, on
/// white; its height is at most its width. Spheres that descend from the same child of the root have the same hue. The
/// root is drawn as glass with the mesh inside. Same arguments, same pixels: it uses no threads, random numbers or
/// mathematical library. Cost: about 1 s for 1600 pixels and 585 spheres; up to 300 bytes a pixel.
/// @throws std::invalid_argument for a view that is not finite or zero, or a width out of range; FormatError for
/// lengths beyond 1e30 mm.
std::vector<std::byte> drawPicture(const TriangleMesh* mesh, const SphereTree& tree, SphereKind kind, const PictureSettings& settings);

}  // namespace spheretree
