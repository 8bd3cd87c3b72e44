// SPDX-License-Identifier: GPL-3.0-or-later
// The content of the panel for a step: figures, and a lamp for each fault and each safety rule.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "panel/viewer_state.h"
#include "run/recording.h"

namespace spheretree::player {

/// The figures of one step and of the last seconds in the plots. A live run adds lines of its own.
std::vector<view::FigureLine> figuresOf(const RecordedStep& step, const view::StepTimes& times);

/// What the burr does. `layers`: the names that RecordedStep::layer counts.
std::vector<view::FigureLine> cutFigures(const RecordedStep& step, std::span<const std::string> layers);

/// A lamp for each bit of runtime::StepFault.
std::vector<view::Lamp> faultLamps(std::uint32_t now, std::uint32_t so_far);
/// A lamp for each bit of device::SafetyEvent.
std::vector<view::Lamp> safetyLamps(std::uint32_t now, std::uint32_t so_far);

/// For example 12'345 as "12,345".
std::string grouped(std::uint64_t count);

}  // namespace spheretree::player
