// SPDX-License-Identifier: Apache-2.0
// A device that is asked for its pose and sent a wrench in each servo step, over a link: a connection or a vendor's
// library. The servo step, and with it every safety rule, is the same for all of them.
#pragma once

#include <memory>

#include "spheretree/device/device.h"

namespace spheretree::device {

/// What a link reports: the handle, its buttons, whether it is released or failed, and the motors' temperature.
struct LinkState {
  Configuration handle;
  std::uint32_t buttons = 0;
  bool released = false, failed = false;
  double temperature = 0;
  std::int32_t code = 0;  // of the last fault or warning, in the numbers of the vendor or of errno; 0: none
};

/// Messages that a link reads in one step: a flood of them must not hold the servo loop.
inline constexpr int kMostMessages = 64;

/// read() and send() are called in the servo loop: they allocate nothing, take no lock and never wait.
class Link {
 public:
  virtual ~Link() = default;  // closes the connection
  /// The open device. Its `can_step` is false for devices that people hold.
  virtual DeviceInfo info() const = 0;
  /// Enables the forces. @throws DeviceError
  virtual void begin() {}
  /// Updates `state` with the newest pose. Returns false if there is none since the last call.
  virtual bool read(LinkState& state) noexcept = 0;
  /// `wrench`: on the hand, about the handle's position, device axes. A link without torques leaves them out.
  virtual void send(const Wrench& wrench) noexcept = 0;
  /// Disables the forces; zero was sent before.
  virtual void end() noexcept {}
};

class LinkedDevice final : public Device {
 public:
  explicit LinkedDevice(std::unique_ptr<Link> link);
  ~LinkedDevice() override { stop(); }

 private:
  void begin(Clock) override;
  bool advance() noexcept override;
  void end() noexcept override;
  void sendZeros() noexcept;

  std::unique_ptr<Link> link_;
  LinkState state_;
  std::uint64_t silent_steps_ = 0;  // since the last pose
};

}  // namespace spheretree::device
