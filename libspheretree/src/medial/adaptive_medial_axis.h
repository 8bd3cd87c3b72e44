// SPDX-License-Identifier: GPL-3.0-or-later
// The medial axis of the solid as balls at Voronoi vertices of surface sites, refined where the ball with the largest
// overhang is.
// Paper: G. Bradshaw, C. O'Sullivan. Adaptive medial-axis approximation for sphere-tree construction. ACM Trans.
//         Graphics 23(1), 2004. Differences: docs/algorithms/medial/adaptive_medial_axis.md
// Units: mm, frame of the mesh. Deterministic: same calls, same balls.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "base/ball.h"
#include "geometry/distance_field.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

class AdaptiveMedialAxis {
 public:
  /// `sites`: points on the surface; equal ones count once. `field` must outlive the object. O(sites) distance queries.
  AdaptiveMedialAxis(const DistanceField& field, std::span<const Eigen::Vector3d> sites);
  ~AdaptiveMedialAxis();
  AdaptiveMedialAxis(const AdaptiveMedialAxis&) = delete;
  AdaptiveMedialAxis& operator=(const AdaptiveMedialAxis&) = delete;

  struct Target {
    double overhang = 0;        // refine until no ball of the region has a larger overhang [mm], >= 0
    std::size_t min_balls = 0;  // ... and until the region has at least this many balls
    std::size_t max_sites = 0;  // ... but insert at most this many sites for it
  };
  /// Refines region by region: takes the ball of the region with the largest overhang, inserts the surface point
  /// nearest to its centre as a new site, and repeats. `region_of` maps a surface point to its region; a ball belongs
  /// to the regions of the sites that it touches. Returns the balls of each region: those at Voronoi vertices inside
  /// the solid, equal centres once; and for a site without such a vertex the ball of shrinking_balls.h. Cost: about 50
  /// us for each new site. @throws Cancelled.
  std::vector<std::vector<FittedBall>> refine(const std::function<std::uint32_t(const Eigen::Vector3d&)>& region_of,
                                              std::span<const Target> regions, Progress& progress);

  std::size_t siteCount() const;
  std::size_t ballCount() const;  // at Voronoi vertices inside the solid; equal centres are counted each time

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace spheretree::builder
