// SPDX-License-Identifier: GPL-3.0-or-later
// The message about a tree that does not keep its tolerance.
#pragma once

#include <cstddef>
#include <string>

namespace spheretree::pipeline {

/// "the tolerance of 0.2 mm is not met; ...": the overhang that the `leaves` have, and an estimate of the leaves that
/// would keep the tolerance, by the rule that the overhang of a smooth surface is inversely proportional to the number
/// of leaves. Both lengths > 0; `leaves` >= 1.
std::string missedTolerance(double tolerance_mm, double kept_mm, std::size_t leaves);

}  // namespace spheretree::pipeline
