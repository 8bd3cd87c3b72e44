// SPDX-License-Identifier: Apache-2.0
// An Inverse3 of Haply through the vendor's service, which speaks JSON on a WebSocket. Written from the messages that
// others publish; what is known of the protocol is in docs/device.md.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "links/web_socket.h"
#include "spheretree/device/linked_device.h"
#include "system/sockets.h"

namespace spheretree::device {

/// What a message says of one arm and of the grip in the hand.
struct HaplyMessage {
  bool has_arm = false, has_pose = false;              // the arm is listed; with its position
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // vendor's frame [m]
  bool has_grip = false;
  Quaternion orientation{1, 0, 0, 0};   // vendor's frame
  std::uint32_t buttons = 0;            // bits: a, b, c
  std::string_view device, handedness;  // of the arm, in the text; handedness may be empty
};

/// `device`: the arm's id; empty: the first arm. Lenient: unknown members are left out, members may be missing.
HaplyMessage readHaply(std::string_view text, std::string_view device) noexcept;

/// The command for a force [N], device axes; its size in `out`.
std::size_t writeHaply(std::string_view device, const Eigen::Vector3d& force, std::span<char> out) noexcept;

/// The frames: ours is +x right, +y up, +z to the user; the vendor's is +x right, +y away from the user, +z up.
Configuration poseOfHaply(const HaplyMessage& message) noexcept;

class HaplyLink final : public Link {
 public:
  /// Connects, and waits up to 2 s for the first pose. @throws DeviceError
  HaplyLink(const SocketAddress& service, const std::string& host, const std::string& device);
  ~HaplyLink() override;
  HaplyLink(const HaplyLink&) = delete;
  HaplyLink& operator=(const HaplyLink&) = delete;

  DeviceInfo info() const override { return info_; }
  bool read(LinkState& state) noexcept override;
  void send(const Wrench& wrench) noexcept override;

 private:
  void connectTo(const SocketAddress& service, const std::string& host);
  void shakeHands(const std::string& host);
  void awaitFirst(const std::string& device);
  void take(const HaplyMessage& message) noexcept;
  void write(WebSocketSend kind, std::string_view payload) noexcept;
  bool flush() noexcept;
  void fail(int code) noexcept;

  Socket socket_{Socket::Kind::Stream};
  WebSocketReader reader_;
  LinkState last_;
  bool has_first_ = false;  // of awaitFirst(), not yet read
  std::string device_;
  DeviceInfo info_;
  std::array<char, 1024> outgoing_{};  // a frame of which the connection took only a part
  std::size_t sent_ = 0, to_send_ = 0;
  std::uint32_t mask_ = 0x9e3779b9u;
  std::int32_t failed_ = 0, ignored_ = 0;  // the system's number of the fault; messages that were not understood
};

}  // namespace spheretree::device
