// SPDX-License-Identifier: GPL-3.0-or-later
// The distance of a triangle from the connected part of a surface that lies over it, by projection: a proof without
// samples, for a large triangle over many small ones as for a small one over a few large ones.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/distance_field.h"

namespace spheretree::builder {

/// For one thread: it remembers which triangles it has met.
class ProjectedCover {
 public:
  explicit ProjectedCover(const DistanceField& field) : field_(field), met_(field.triangleCount()) {}

  /// The triangles of the surface that are reached from `start` over sides whose projections along `along`, any
  /// direction out of the plane of `triangle`, meet it. They have no border over `triangle`, so they cover each of its
  /// points equally often, if those that face down count as -1: once, if the sum of their projected areas says so. No
  /// point is then farther from the surface than the farthest corner of the polygons in which the projections overlap
  /// `triangle`, since the distance to one triangle is convex.
  /// Infinite if that is more than `allowed`, or if they do not cover `triangle`; distances of up to `floor` are not
  /// told apart. Cost: linear in the triangles over `triangle`.
  double distance(const std::array<Eigen::Vector3d, 3>& triangle, const Eigen::Vector3d& along, std::uint32_t start, double floor,
                  double allowed);

  /// For hasMet(): the searches so far.
  std::uint32_t searches() const { return search_; }
  /// Whether one of the searches after the first `searches` met this triangle of the surface. A search for the same
  /// triangle and direction that starts there goes to the same places.
  bool hasMet(std::uint32_t triangle, std::uint32_t searches) const { return met_[triangle] > searches; }

  /// The point of the triangle that the last search found farthest from what lies over it, also if that is farther than
  /// allowed; none if no point is farther than `floor`.
  const std::optional<Eigen::Vector3d>& farthest() const { return farthest_; }

 private:
  const DistanceField& field_;
  std::vector<std::uint32_t> met_;  // (triangles) number of the last search that met it
  std::uint32_t search_ = 0;
  std::vector<std::uint32_t> to_do_;
  std::optional<Eigen::Vector3d> farthest_;
};

}  // namespace spheretree::builder
