// SPDX-License-Identifier: Apache-2.0
// A device that another program serves by spheretree.device/1.
#pragma once

#include <netinet/in.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "net_packet.h"
#include "spheretree/device/linked_device.h"

namespace spheretree::device {

/// A UDP socket that never waits.
class NetSocket {
 public:
  NetSocket(const sockaddr_in& address, bool is_server);  // @throws DeviceError
  ~NetSocket();
  NetSocket(const NetSocket&) = delete;
  NetSocket& operator=(const NetSocket&) = delete;

  /// The next valid message of that kind; messages that are not are dropped. `from`: who sent it.
  std::optional<NetPacket> receive(NetPacket::Kind kind, sockaddr_in& from) noexcept;
  void send(const NetPacket& packet, const sockaddr_in& to) noexcept;  // the time is set here
  std::uint16_t port() const noexcept;

  sockaddr_in peer{};  // of a server: the client that it answers

 private:
  int socket_ = -1;
};

class NetLink final : public Link {
 public:
  /// Waits up to 2 s for the first pose. @throws DeviceError
  explicit NetLink(const sockaddr_in& server, const std::string& name);
  DeviceInfo info() const override { return info_; }
  bool read(LinkState& state) noexcept override;
  void send(const Wrench& wrench) noexcept override;

 private:
  sockaddr_in server_;
  NetSocket socket_;
  DeviceInfo info_;
  NetPacket last_;
  bool has_first_ = false;  // of the constructor, not yet read
  std::uint64_t sequence_ = 0;
  std::chrono::steady_clock::time_point heard_;
};

}  // namespace spheretree::device
