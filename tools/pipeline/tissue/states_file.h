// SPDX-License-Identifier: GPL-3.0-or-later
// States of soft tissue from a CSV file.
#pragma once

#include <filesystem>
#include <vector>

#include "tissue/sample_states.h"

namespace spheretree::pipeline {

inline constexpr std::size_t kMaxStates = 100'000;

/// Header `state,node,dx_mm,dy_mm,dz_mm`, then a row for each moved node. States are numbered from 0 in ascending
/// order; nodes without a row are at rest. @throws formats::FileError, formats::FormatError with the line.
std::vector<builder::TissueState> readStates(const std::filesystem::path& path, std::size_t nodes);

}  // namespace spheretree::pipeline
