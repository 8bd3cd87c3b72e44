// SPDX-License-Identifier: GPL-3.0-or-later
// The mesh of soft tissue as it is deformed, its stretch in colour. Units: mm.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "model/stage.h"
#include "spheretree/core/tissue.h"

namespace spheretree::view {

/// Full colour stands for edges that are this much longer or shorter than at rest.
inline constexpr double kFullStretch = 0.5;

/// A drawn surface, tied to tissue.
class MovedSurface {
 public:
  /// Each corner goes with the vertex of the tissue that is nearest to it: that is where it stands itself if the mesh
  /// is the one that the tree was built from.
  MovedSurface(const Surface& rest, std::shared_ptr<const Tissue> tissue);

  /// With the nodes moved by `displacements`; normals are those of the faces, colours go from `colour` to heat() with
  /// the stretch of the edges. Cost: about 0.1 us a corner.
  TintedSurface at(std::span<const Eigen::Vector3f> displacements, Colour colour) const;

 private:
  Surface rest_;
  std::shared_ptr<const Tissue> tissue_;
  std::vector<std::uint32_t> vertex_;  // (corner) of the tissue's surface
};

}  // namespace spheretree::view
