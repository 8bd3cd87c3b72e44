// SPDX-License-Identifier: GPL-3.0-or-later
// What a user is told of a tree that does not keep its tolerance.
#pragma once

#include <cstddef>
#include <string>

namespace spheretree::pipeline {

/// "the tolerance of 0.2 mm is not met; ...": what the `leaves` keep, and about how many would keep the tolerance, by
/// the rule that the overhang of a smooth surface falls as one over the leaves. Both lengths above 0; `leaves` >= 1.
std::string missedTolerance(double tolerance_mm, double kept_mm, std::size_t leaves);

}  // namespace spheretree::pipeline
