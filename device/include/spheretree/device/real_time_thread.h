// SPDX-License-Identifier: Apache-2.0
// A thread that ordinary programs do not delay.
#pragma once

namespace spheretree::device {

/// Asks the system for a real-time priority for the calling thread. Returns 0, or the system's number of the reason.
int requestRealTimeThread() noexcept;

}  // namespace spheretree::device
