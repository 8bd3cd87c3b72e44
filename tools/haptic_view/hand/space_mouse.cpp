// SPDX-License-Identifier: GPL-3.0-or-later
#include "hand/space_mouse.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>

namespace spheretree::view {

SpaceMouse::SpaceMouse() {
  const char* named = std::getenv("SPNAV_SOCKET");
  const std::string path = named && *named ? named : "/var/run/spnav.sock";
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) {
    fault_ = "the name of the socket is too long: " + path;
    return;
  }
  std::memcpy(address.sun_path, path.c_str(), path.size());
  socket_ = ::socket(AF_UNIX, SOCK_STREAM, 0);
  if (socket_ >= 0 && ::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
    ::fcntl(socket_, F_SETFL, O_NONBLOCK);
    return;
  }
  fault_ = "no 3D mouse: " + path + ": " + std::strerror(errno) + ". Install and start spacenavd, or set SPNAV_SOCKET";
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

SpaceMouse::~SpaceMouse() {
  if (socket_ >= 0) ::close(socket_);
}

const std::array<int, 6>& SpaceMouse::poll() {
  // An event is eight 32-bit numbers: kind (0: motion, 1 and 2: buttons), then x, y, z and the rotations with z away
  // from the user, and the time since the previous event.
  while (socket_ >= 0) {
    const ssize_t got = ::recv(socket_, event_.data() + filled_, sizeof event_ - filled_, 0);
    if (got == 0 || (got < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR)) {
      ::close(socket_);
      socket_ = -1;
      fault_ = "the connection to the 3D mouse was lost: spacenavd has ended";
      motion_ = {};
      break;
    }
    if (got < 0) break;
    filled_ += static_cast<std::size_t>(got);
    if (filled_ < sizeof event_) continue;  // the rest may not have arrived yet
    filled_ = 0;
    std::array<std::int32_t, 8> event;
    std::memcpy(event.data(), event_.data(), sizeof event);
    was_pressed_ = was_pressed_ || event[0] == 1;
    if (event[0] == 0) motion_ = {event[1], event[2], -event[3], event[4], event[5], -event[6]};
  }
  return motion_;
}

}  // namespace spheretree::view
