// SPDX-License-Identifier: GPL-3.0-or-later
// The mesh of deformed soft tissue, with its stretch shown in colour. Units: mm.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "model/stage.h"
#include "spheretree/core/tissue.h"

namespace spheretree::view {

/// Relative change of an edge's length that is shown in full colour.
inline constexpr double kFullStretch = 0.5;

/// A surface for drawing that is attached to tissue.
class MovedSurface {
 public:
  /// Each corner moves with the nearest vertex of the tissue. For the mesh from which the tree was built, that is the
  /// vertex at the corner itself.
  MovedSurface(const Surface& rest, std::shared_ptr<const Tissue> tissue);

  /// The surface with the nodes moved by `displacements`. Normals are those of the faces; colours go from `colour` to
  /// heat() with the stretch of the edges. Cost: about 0.1 us a corner.
  TintedSurface at(std::span<const Eigen::Vector3f> displacements, Colour colour) const;

 private:
  Surface rest_;
  std::shared_ptr<const Tissue> tissue_;
  std::vector<std::uint32_t> vertex_;  // (corner) of the tissue's surface
};

}  // namespace spheretree::view
