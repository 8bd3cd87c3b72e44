// SPDX-License-Identifier: GPL-3.0-or-later
// A proven lower bound of the number of balls that cover a surface with a given overhang, and of the overhang that a
// given number of balls needs. Theorem and proof: docs/algorithms/measure/lower_bound.md
// Paper: Z. Allen-Zhu, L. Orecchia. Nearly linear-time packing and covering LP solvers. Math. Program. 175, 2019 (the
//        weights; the proof does not rest on it).
// Units: mm. Deterministic: same arguments, same result, for any number of threads.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "geometry/distance_field.h"
#include "geometry/sample_index.h"
#include "spheretree/builder/evaluation.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

class WitnessIndex;

class LowerBound {
 public:
  /// `field`: of the solid and its sheets, without slack; `surface`: what has to be covered. Both must outlive this
  /// object. The effort suits bounds of about `spheres` balls.
  /// @throws Cancelled, std::invalid_argument for no spheres or a surface without area.
  LowerBound(const TriangleMesh& surface, const DistanceField& field, std::size_t spheres, std::uint64_t seed, Progress& progress);

  /// Fewer balls than this do not cover the surface if each of their points is inside the solid or at most `overhang`
  /// [mm, > 0] from its surface.
  double spheresNeeded(double overhang, Progress& progress) const;

  /// Points of the surface with weights. No ball as above holds more than a weight of 1.
  struct Weights {
    std::vector<double> weight;  // by slot of points()
    double total = 0;            // rounded down
  };
  Weights weights(double overhang, Progress& progress) const;
  const SampleIndex& points() const { return points_; }

 private:
  std::vector<double> balancedWeights(const WitnessIndex& witnesses, double overhang, Progress& progress) const;

  const DistanceField& field_;
  SampleIndex points_;
  std::size_t count_ = 0;
  std::vector<Eigen::Vector3d> medial_;  // centres of medial balls
};

/// The largest overhang found for which `bound` proves that `spheres` balls are too few; `upper` is the overhang of
/// some cover of that many balls. 0 if none was found.
ProvenLimit provenLimit(const LowerBound& bound, std::size_t spheres, double upper, Progress& progress);

}  // namespace spheretree::builder
