// SPDX-License-Identifier: Apache-2.0
#include "net_address.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <sys/socket.h>

#include <charconv>
#include <cstring>

#include "spheretree/device/device.h"

namespace spheretree::device {

std::uint16_t portOf(const std::string& text) noexcept {
  unsigned port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc() && end == text.data() + text.size() && port <= 65535 ? static_cast<std::uint16_t>(port) : 0;
}

sockaddr_in addressOf(const std::string& text, bool allow_remote, const std::string& what) {
  const std::size_t colon = text.rfind(':');
  const std::string host = text.substr(0, colon);
  const std::uint16_t port = colon == std::string::npos ? std::uint16_t{0} : portOf(text.substr(colon + 1));
  if (host.empty() || port == 0)
    throw DeviceError(DeviceFault::Refused, what + ": '" + text + "' is not HOST:PORT with a port from 1 to 65535");
  addrinfo hints{};
  hints.ai_family = AF_INET;
  addrinfo* found = nullptr;
  if (const int error = ::getaddrinfo(host.c_str(), nullptr, &hints, &found); error != 0)
    throw DeviceError(DeviceFault::NotFound,
                      what + ": host '" + host + "': " + ::gai_strerror(error) + ". Check its name, or give its number");
  sockaddr_in address;
  std::memcpy(&address, found->ai_addr, sizeof address);
  ::freeaddrinfo(found);
  address.sin_port = htons(port);
  constexpr std::uint32_t kLoopback = 127;  // first byte of all addresses of the machine itself
  if (ntohl(address.sin_addr.s_addr) >> 24 != kLoopback && !allow_remote)
    throw DeviceError(DeviceFault::Refused, what + ": " + host +
                                                " is another machine, from which forces may come late or from a stranger: allow it with "
                                                "`allow_remote` (haptic-player: --allow-remote), in a network that you trust");
  return address;
}

}  // namespace spheretree::device
