// SPDX-License-Identifier: GPL-3.0-or-later
// What keeps a servo loop in time, as far as the system has it: real_time_posix.cpp and real_time_windows.cpp.
#pragma once

#include <string>

namespace spheretree::player {

/// What an error of device::requestRealTimeThread() means, and what to do.
std::string priorityAdvice(int error);

/// Locks all memory, so that the servo thread never waits for the disk. Returns what to say if that fails, otherwise
/// nothing.
std::string lockMemory();

/// Processor time of the calling thread [us].
double threadTime() noexcept;

}  // namespace spheretree::player
