// SPDX-License-Identifier: Apache-2.0
// Addresses of the form HOST:PORT, and which of them are of this machine.
#pragma once

#include <cstdint>
#include <string>

#include "system/sockets.h"

namespace spheretree::device {

/// @throws DeviceError Refused if `text` is no HOST:PORT, or if the host is another machine without `allow_remote`;
/// NotFound if there is no such host. `what`: begins the message.
SocketAddress addressOf(const std::string& text, bool allow_remote, const std::string& what);

/// A port from 1 to 65535, or 0 if `text` is none.
std::uint16_t portOf(const std::string& text) noexcept;

}  // namespace spheretree::device
