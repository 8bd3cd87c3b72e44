// SPDX-License-Identifier: Apache-2.0
#include "links/net_address.h"

#include <charconv>

#include "spheretree/device/device.h"

namespace spheretree::device {

std::uint16_t portOf(const std::string& text) noexcept {
  unsigned port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc() && end == text.data() + text.size() && port <= 65535 ? static_cast<std::uint16_t>(port) : 0;
}

SocketAddress addressOf(const std::string& text, bool allow_remote, const std::string& what) {
  const std::size_t colon = text.rfind(':');
  const std::string host = text.substr(0, colon);
  const std::uint16_t port = colon == std::string::npos ? std::uint16_t{0} : portOf(text.substr(colon + 1));
  if (host.empty() || port == 0)
    throw DeviceError(DeviceFault::Refused, what + ": '" + text + "' is not HOST:PORT with a port from 1 to 65535");
  std::string why;
  const std::optional<std::uint32_t> found = findHost(host, why);
  if (!found) throw DeviceError(DeviceFault::NotFound, what + ": host '" + host + "': " + why + ". Check its name, or give its number");
  constexpr int kFirstByte = 24;  // that of 127.0.0.1 begins all addresses of the machine itself
  if (*found >> kFirstByte != kThisHost >> kFirstByte && !allow_remote)
    throw DeviceError(DeviceFault::Refused, what + ": " + host +
                                                " is another machine, from which forces may come late or from a stranger: allow it with "
                                                "`allow_remote` (haptic-player: --allow-remote), in a network that you trust");
  return {*found, port};
}

}  // namespace spheretree::device
