// SPDX-License-Identifier: Apache-2.0
// Serves a device to a program on this or another machine, by spheretree.device/1: docs/device.md
#pragma once

#include <cstdint>
#include <memory>

#include "spheretree/device/device.h"

namespace spheretree::device {

class NetSocket;

/// A renderer that sends each pose to its client and renders the client's last wrench, whose age the safety rules of
/// the served device see: a client that pauses fades, and one that is gone switches the forces off.
class DeviceServer final : public Renderer {
 public:
  /// Listens on this machine's own address only, unless `allow_remote`. `info`: of the device that is served.
  /// @throws DeviceError Refused if the port is in use.
  DeviceServer(std::uint16_t port, bool allow_remote, const DeviceInfo& info);
  ~DeviceServer();

  Rendered render(const DeviceState& state) noexcept override;

  std::uint16_t port() const noexcept;  // the one that the system chose, if `port` is 0
  /// Whether a client sends wrenches now. If the forces are off then, Device::rearm() lets them return.
  bool hasClient() const noexcept { return has_client_.load(std::memory_order_relaxed); }

 private:
  std::unique_ptr<NetSocket> socket_;
  bool renders_torque_;
  Wrench wrench_;
  double heard_ = 0;            // time of the last message of the client [s]
  bool was_heard_ = false;      // a client connected since the start
  std::uint64_t sequence_ = 0;  // of the next message
  std::uint64_t last_ = 0;      // sequence number of the client's last message
  std::atomic<bool> has_client_{false};
};

}  // namespace spheretree::device
