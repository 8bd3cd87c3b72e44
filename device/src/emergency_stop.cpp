// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/emergency_stop.h"

#include <atomic>

#include "system/system_calls.h"

namespace spheretree::device {
namespace {

// The only data that a signal handler accesses: lock-free, so async-signal-safe, and read by the servo thread at its
// next step.
std::atomic<int> caught_signal{0};
std::atomic<bool> stop_requested{false};
std::atomic<int> living{0};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free);

extern "C" void onSignal(int number) {
  caught_signal.store(number, std::memory_order_relaxed);
  stop_requested.store(true, std::memory_order_relaxed);
}

}  // namespace

EmergencyStop::EmergencyStop() : signals_(std::make_unique<EndingSignals>(onSignal)) { living.fetch_add(1); }

EmergencyStop::~EmergencyStop() {
  signals_.reset();
  if (living.fetch_sub(1) > 1) return;
  caught_signal.store(0);
  stop_requested.store(false);
}

void EmergencyStop::request() noexcept { stop_requested.store(true, std::memory_order_relaxed); }
bool EmergencyStop::requested() noexcept { return stop_requested.load(std::memory_order_relaxed); }
int EmergencyStop::signal() noexcept { return caught_signal.load(std::memory_order_relaxed); }

}  // namespace spheretree::device
