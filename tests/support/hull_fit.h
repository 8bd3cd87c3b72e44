// SPDX-License-Identifier: GPL-3.0-or-later
// A fit of hulls to a mesh, step by step.
#pragma once

#include <algorithm>
#include <cstdint>
#include <set>
#include <utility>

#include "hulls/hull_complex.h"

namespace spheretree::test {

/// What a fit works on; not copied, since its parts refer to each other.
struct HullFitRig {
  TriangleMesh mesh;
  builder::DistanceField field;
  builder::Progress progress;
  builder::FitTask task;

  HullFitRig(TriangleMesh of, double tolerance)
      : mesh(std::move(of)), field(mesh), task(mesh, field, {.tolerance = tolerance, .rounding = 1e-6, .max_hulls = 100}, progress) {}
  HullFitRig(const HullFitRig&) = delete;
  HullFitRig& operator=(const HullFitRig&) = delete;

  /// Joined balls that hold all samples.
  builder::HullComplex joined() const {
    builder::HullComplex complex(task);
    complex.addFirstBalls();
    complex.join(complex.balls());
    return complex;
  }
};

inline std::size_t livingBalls(const builder::HullComplex& complex) {
  std::size_t count = 0;
  for (std::uint32_t v = 0; v < complex.balls().size(); ++v) count += !complex.around(v).empty();
  return count;
}

/// The largest cost of a sample.
inline double worstSample(const builder::HullComplex& complex) {
  double worst = 0;
  for (const builder::FitSample& s : complex.samples()) worst = std::max(worst, s.cost);
  return worst;
}

/// Whether each sample belongs to one living hull, at the cost that this hull has for it.
inline bool isConsistent(const builder::HullComplex& complex) {
  std::set<std::uint32_t> seen;
  for (const builder::Simplex& s : complex.simplices())
    for (const std::uint32_t p : s.samples)
      if (!s.is_alive || !seen.insert(p).second || s.costOf(complex.samples()[p].point) != complex.samples()[p].cost) return false;
  return seen.size() == complex.samples().size();
}

}  // namespace spheretree::test
