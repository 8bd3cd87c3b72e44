// SPDX-License-Identifier: GPL-3.0-or-later
// From the hulls of a complex to a few that provably cover the surface. docs/algorithms/hulls/fit_hulls.md
// Units: mm.
#pragma once

#include <vector>

#include "geometry/hull.h"
#include "hulls/hull_complex.h"

namespace spheretree::builder {

struct ChosenHulls {
  std::vector<Hull> hulls{};  // in the order in which they were chosen
  bool is_thin = false;       // whether the solid is, in places, about as thin as the tolerance
};

/// The hulls of the compact complex, grown to the tolerance, and balls for what they leave bare. @throws Cancelled.
ChosenHulls chooseHulls(const HullComplex& complex);

}  // namespace spheretree::builder
