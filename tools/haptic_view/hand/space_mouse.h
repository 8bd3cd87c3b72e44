// SPDX-License-Identifier: GPL-3.0-or-later
// A 3D mouse through the daemon spacenavd, by its protocol over a local socket, so that no library is needed. Never
// blocks.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <utility>

namespace spheretree::view {

class SpaceMouse {
 public:
  /// Connects to the socket that SPNAV_SOCKET names, otherwise to /var/run/spnav.sock. Check isOpen() afterwards.
  SpaceMouse();
  ~SpaceMouse();
  SpaceMouse(const SpaceMouse&) = delete;
  SpaceMouse& operator=(const SpaceMouse&) = delete;

  bool isOpen() const { return socket_ >= 0; }
  /// Why it is not open, and what to do.
  const std::string& fault() const { return fault_; }
  /// The newest motion: right, up, towards the user, and rotations about these axes; full deflection is about 350. Zero
  /// at rest, and after the daemon has ended.
  const std::array<int, 6>& poll();
  /// Whether a button was pressed since the last call.
  bool takePress() { return std::exchange(was_pressed_, false); }

 private:
  int socket_ = -1;
  std::string fault_;
  std::array<char, 32> event_{};  // the part of the event received so far
  std::size_t filled_ = 0;
  std::array<int, 6> motion_{};
  bool was_pressed_ = false;
};

}  // namespace spheretree::view
