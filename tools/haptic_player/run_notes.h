// SPDX-License-Identifier: GPL-3.0-or-later
// What a user should know of a run that went well by its figures, but may not have done what was meant.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "play.h"

namespace spheretree::player {

/// Whole sentences: a tool that touched nothing, objects that the simulated hand did not come to, a trajectory that
/// ended early or is coarse.
/// `steps`, `largest_force_n`: of the run, which came to its end. @throws formats::FileError, formats::FormatError
std::vector<std::string> notesOn(const PlaySettings& settings, std::uint64_t steps, double largest_force_n);

}  // namespace spheretree::player
