// SPDX-License-Identifier: Apache-2.0
// The contact problem with Law::Discs or Law::Cones, which is convex, from any start.
// Paper: R. T. Rockafellar. Augmented Lagrangians and applications of the proximal point algorithm in convex
// programming. Math. Oper. Res. 1(2), 1976.
#pragma once

#include "contact/contact_system.h"

namespace spheretree::runtime {

/// Leaves allowed forces in the system. False: they are not those of the minimum within the tolerance.
bool approachMinimum(ContactSystem& system) noexcept;

}  // namespace spheretree::runtime
