// SPDX-License-Identifier: Apache-2.0
// A device that another program serves by spheretree.device/1.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "links/net_packet.h"
#include "spheretree/device/linked_device.h"
#include "system/sockets.h"

namespace spheretree::device {

/// A UDP socket that never waits.
class NetSocket {
 public:
  NetSocket(const SocketAddress& address, bool is_server);  // @throws DeviceError

  /// The next valid message of that kind; messages that are not are dropped. `from`: who sent it.
  std::optional<NetPacket> receive(NetPacket::Kind kind, SocketAddress& from) noexcept;
  void send(const NetPacket& packet, const SocketAddress& to) noexcept;  // the time is set here
  std::uint16_t port() const noexcept;

  SocketAddress peer{};  // of a server: the client that it answers

 private:
  Socket socket_{Socket::Kind::Datagrams};
};

class NetLink final : public Link {
 public:
  /// Waits up to 2 s for the first pose. @throws DeviceError
  explicit NetLink(const SocketAddress& server, const std::string& name);
  DeviceInfo info() const override { return info_; }
  bool read(LinkState& state) noexcept override;
  void send(const Wrench& wrench) noexcept override;

 private:
  SocketAddress server_;
  NetSocket socket_;
  DeviceInfo info_;
  NetPacket last_;
  bool has_first_ = false;  // of the constructor, not yet read
  std::uint64_t sequence_ = 0;
  std::chrono::steady_clock::time_point heard_;
};

}  // namespace spheretree::device
