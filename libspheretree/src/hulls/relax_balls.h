// SPDX-License-Identifier: GPL-3.0-or-later
// Moves neighbouring balls of a complex so that the hulls between them share what they cost.
// docs/algorithms/hulls/fit_hulls.md
// Units: mm.
#pragma once

#include <cstdint>

#include "hulls/hull_complex.h"

namespace spheretree::builder {

/// Moves the balls nearest to ball `centre` until the hulls there cost at most complex.most(); `limit`: what they may
/// cost until then [mm]. Moved balls get new numbers.
void relaxBalls(HullComplex& complex, std::uint32_t centre, double limit);

}  // namespace spheretree::builder
