// SPDX-License-Identifier: Apache-2.0
// The contact problem with Law::Discs or Law::Cones, which is convex, from any start.
// Paper: R. T. Rockafellar. Augmented Lagrangians and applications of the proximal point algorithm in convex
// programming. Math. Oper. Res. 1(2), 1976.
#pragma once

#include "contact/contact_system.h"

namespace spheretree::runtime {

/// Leaves allowed forces in the system, and their motions: those of the minimum, unless the work is used up before.
void approachMinimum(ContactSystem& system) noexcept;

}  // namespace spheretree::runtime
