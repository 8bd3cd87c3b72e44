// SPDX-License-Identifier: GPL-3.0-or-later
// Notes on a run that succeeded according to its figures, but may not have done what the user intended.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "run/play.h"

namespace spheretree::player {

/// Whole sentences: about a tool that touched nothing, objects that the simulated hand did not reach, a trajectory that
/// ended early or is coarse. `steps`, `largest_force_n`: of the run, which must have come to its end. @throws
/// formats::FileError, formats::FormatError
std::vector<std::string> notesOn(const PlaySettings& settings, bool is_steered, std::uint64_t steps, double largest_force_n,
                                 bool renders_torque);

}  // namespace spheretree::player
