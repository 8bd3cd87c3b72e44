// SPDX-License-Identifier: Apache-2.0
// Ctrl-C, kill and hang-up take the forces off before anything else happens.
#pragma once

#include <csignal>

namespace spheretree::device {

/// While one lives, SIGINT, SIGTERM and SIGHUP request an emergency stop; its end restores the former handlers and, if
/// it was the last, withdraws the request. Every started device then sends zero from its next servo step on and goes to
/// Phase::Halted.
class EmergencyStop {
 public:
  EmergencyStop();
  ~EmergencyStop();
  EmergencyStop(const EmergencyStop&) = delete;
  EmergencyStop& operator=(const EmergencyStop&) = delete;

  /// From any thread, and from a signal handler.
  static void request() noexcept;
  static bool requested() noexcept;
  /// The signal that asked for it; 0 if none did.
  static int signal() noexcept;

 private:
  static constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};
  struct sigaction former_[3];
};

}  // namespace spheretree::device
