// SPDX-License-Identifier: GPL-3.0-or-later
// Makes the hulls of a complex fewer: two neighbouring balls become one of them, the least costly first, as edges
// collapse in H. Hoppe, Progressive meshes, SIGGRAPH 1996. docs/algorithms/hulls/fit_hulls.md
// Units: mm.
#pragma once

#include "hulls/hull_complex.h"

namespace spheretree::builder {

/// As long as what becomes worse costs at most complex.most(). Pairs that cost about the same are taken by their
/// distance. @throws Cancelled.
void collapseBalls(HullComplex& complex);

/// Then pairs that cost more, if the balls around can be moved so that the hulls hold the whole surface all the same.
/// @throws Cancelled.
void tryCollapses(HullComplex& complex);

}  // namespace spheretree::builder
