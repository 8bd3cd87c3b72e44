// SPDX-License-Identifier: GPL-3.0-or-later
// What the panel says of a step: figures, and a lamp for each fault and each safety rule.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "panel/viewer_state.h"
#include "recording.h"

namespace spheretree::player {

/// Of one step and the plots' last seconds. A live run adds its own lines.
std::vector<view::FigureLine> figuresOf(const RecordedStep& step, const view::StepTimes& times);

/// A lamp for each bit of runtime::StepFault.
std::vector<view::Lamp> faultLamps(std::uint32_t now, std::uint32_t so_far);
/// And of device::SafetyEvent.
std::vector<view::Lamp> safetyLamps(std::uint32_t now, std::uint32_t so_far);

/// 12'345 as "12,345".
std::string grouped(std::uint64_t count);

}  // namespace spheretree::player
