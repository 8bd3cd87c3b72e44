// SPDX-License-Identifier: Apache-2.0
// Switches the forces off on SIGINT, SIGTERM and SIGHUP, before anything else happens. On Windows the third one is
// SIGBREAK, which also says that the console is closed.
#pragma once

#include <memory>

namespace spheretree::device {

class EndingSignals;

/// While an EmergencyStop exists, these signals request an emergency stop. Its destructor restores the
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
  std::unique_ptr<EndingSignals> signals_;
};

}  // namespace spheretree::device
