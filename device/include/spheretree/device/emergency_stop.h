// SPDX-License-Identifier: Apache-2.0
// Switches the forces off on SIGINT, SIGTERM and SIGHUP, before anything else happens.
#pragma once

#include <csignal>

namespace spheretree::device {

/// While an EmergencyStop exists, SIGINT, SIGTERM and SIGHUP request an emergency stop. Its destructor restores the
/// former handlers; the destructor of the last one also withdraws the request. After a request every started device
/// sends zero from its next servo step on and enters Phase::Halted.
class EmergencyStop {
 public:
  EmergencyStop();
  ~EmergencyStop();
  EmergencyStop(const EmergencyStop&) = delete;
  EmergencyStop& operator=(const EmergencyStop&) = delete;

  /// May be called from any thread and from a signal handler.
  static void request() noexcept;
  static bool requested() noexcept;
  /// The signal that requested the stop; 0 if none did.
  static int signal() noexcept;

 private:
  static constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};
  struct sigaction former_[3];
};

}  // namespace spheretree::device
