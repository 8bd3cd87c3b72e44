// SPDX-License-Identifier: GPL-3.0-or-later
// A 3D mouse by the daemon spacenavd: its protocol over a local socket, so that no library is needed. Never waits.
#pragma once

#include <array>
#include <cstddef>
#include <string>

namespace spheretree::view {

class SpaceMouse {
 public:
  /// Connects to the socket that SPNAV_SOCKET names, else to /var/run/spnav.sock. Check isOpen().
  SpaceMouse();
  ~SpaceMouse();
  SpaceMouse(const SpaceMouse&) = delete;
  SpaceMouse& operator=(const SpaceMouse&) = delete;

  bool isOpen() const { return socket_ >= 0; }
  /// Why it is not open, and what to do.
  const std::string& fault() const { return fault_; }
  /// The newest motion: right, up, towards the user, and turns about these axes; about 350 is the full way. Zero while
  /// it rests, and once the daemon has gone.
  const std::array<int, 6>& poll();

 private:
  int socket_ = -1;
  std::string fault_;
  std::array<char, 32> event_{};  // as far as it has come
  std::size_t filled_ = 0;
  std::array<int, 6> motion_{};
};

}  // namespace spheretree::view
