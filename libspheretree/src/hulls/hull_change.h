// SPDX-License-Identifier: GPL-3.0-or-later
// What it costs to put a ball of a complex elsewhere, or a neighbour in its place: the hulls that this makes, and who
// holds the samples of those that go. docs/algorithms/hulls/fit_hulls.md
// Units: mm.
#pragma once

#include <cstdint>

#include "hulls/hull_complex.h"

namespace spheretree::builder {

/// Ball `from` becomes its neighbour `to`. The cost of either change is infinite if it exceeds `limit` [mm].
HullChange collapseOf(const HullComplex& complex, std::uint32_t from, std::uint32_t to, double limit);

/// Ball `from` becomes a new one.
HullChange moveOf(const HullComplex& complex, std::uint32_t from, const Ball& ball, double limit);

}  // namespace spheretree::builder
