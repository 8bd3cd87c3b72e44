// SPDX-License-Identifier: GPL-3.0-or-later
// States of soft tissue from a CSV file.
#pragma once

#include <filesystem>
#include <vector>

#include "tissue/sample_states.h"

namespace spheretree::pipeline {

inline constexpr std::size_t kMaxStates = 100'000;

/// Header `state,node,dx_mm,dy_mm,dz_mm`, then a row for each node that has moved; states count from 0 and stand in
/// order, nodes that have no row are where they were. @throws formats::FileError, formats::FormatError with the line.
std::vector<builder::TissueState> readStates(const std::filesystem::path& path, std::size_t nodes);

}  // namespace spheretree::pipeline
