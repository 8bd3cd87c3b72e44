// SPDX-License-Identifier: Apache-2.0
// The balls along the wall of what a burr removed of an object, from the fields of its lattice.
// Units: mm; frame: axes of the object, origin at the centre of its shape.
#pragma once

#include <bit>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "cut/cut_lattice.h"

namespace spheretree::runtime {

class LatticeWall {
 public:
  /// `lattice` must outlive the object.
  explicit LatticeWall(const CutLattice& lattice) : lattice_(lattice), spacing_(lattice.spacing()) {}

  double largestBall() const { return kWallSpacings * spacing_; }
  /// The wall has balls about points of a block in the material, as large as fits, where something was removed nearby:
  /// they come to within a small play of what was removed.
  Sphere ball(const CutBlock& block, std::size_t point) const;
  /// Calls visit(point) for the balls of the wall that are within `reach` of `centre`, and for some that are as near
  /// but for rounding; in ascending order.
  template <class Visit>
  void visit(const CutBlock& block, const Eigen::Vector3d& centre, double reach, Visit&& visit) const {
    std::uint8_t near[kBlockPoints / 8];
    findNear(block, centre, reach, near);
    for (std::size_t row = 0; row < kBlockPoints / 8; ++row)
      for (unsigned lanes = near[row]; lanes; lanes &= lanes - 1) visit(8 * row + static_cast<std::size_t>(std::countr_zero(lanes)));
  }
  /// Small balls along the rim, where what was removed meets the surface of the object at an angle: those of the wall
  /// would leave it round. Found anew where something was removed since.
  std::span<const Sphere> rimOf(CutBlock& block) const;

 private:
  void findRim(CutBlock& block) const;
  /// The gradients of both fields at a point of a block; false beside a block that was not made.
  bool gradientsAt(const CutBlock& block, std::size_t point, Eigen::Vector3d& depth, Eigen::Vector3d& clearance) const;
  void findNear(const CutBlock& block, const Eigen::Vector3d& centre, double reach, std::uint8_t* near) const;

  const CutLattice& lattice_;
  const double spacing_;
};

}  // namespace spheretree::runtime
