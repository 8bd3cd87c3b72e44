// SPDX-License-Identifier: Apache-2.0
// A Phantom through the vendor's HDAPI (OpenHaptics 3), which is loaded when it is asked for: nothing of the vendor is
// needed to build. Conventions, order of calls, first use with hardware: docs/device.md
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "spheretree/device/device.h"

namespace spheretree::device {

struct HdApi;

/// How a device takes its torque. No program can find out: try Cartesian with 10 N mm first.
enum class TorqueConvention : std::uint8_t {
  Cartesian,  // HD_CURRENT_TORQUE: vector in device axes
  Gimbal,  // HD_CURRENT_GIMBAL_TORQUE: about the yaw, pitch and roll joint; the handle turns by Ry(yaw) Rx(pitch) Rz(roll) against its base
};

struct PhantomSettings {
  std::string library;  // path of the vendor's library; empty: libHD.so and its known versions, where the loader looks
  std::string device;   // name in the vendor's configuration; empty: the first device, else "Default PHANToM", else "Default Device"
  TorqueConvention torque = TorqueConvention::Cartesian;
  bool calibrate = false;  // the arm is in its reset pose: take it as such (devices with encoder reset, once after power-up)
  std::string vendor, application, password;  // of a deployment licence, if `vendor` is not empty
};

class PhantomDevice final : public Device {
 public:
  /// Loads, opens, checks the calibration; the forces stay off. One at a time in a process.
  /// @throws DeviceError LibraryMissing (the loader's own words for each place looked at), SymbolMissing, NotFound,
  /// NotCalibrated, Communication.
  explicit PhantomDevice(const PhantomSettings& settings);
  ~PhantomDevice() override;

 private:
  void openDevice();
  void readInfo();
  void checkCalibration();
  void begin(Clock) override;
  bool advance() noexcept override { return false; }
  void end() noexcept override;
  bool hasOwnClock() const noexcept override { return true; }
  static std::uint32_t onServo(void* self) noexcept;
  std::uint32_t servo() noexcept;
  DeviceState measured() noexcept;
  void send(const Wrench& wrench) noexcept;
  void drainInServo() noexcept;
  bool accepted(const std::function<void()>& call) const;
  std::string drain() const;

  const HdApi* api_;
  PhantomSettings settings_;
  std::uint32_t handle_;
  unsigned long callback_ = 0;
  std::atomic<bool> quit_{false};
  int zeros_sent_ = 0;
  bool failed_ = false, interrupted_ = false, warm_ = false, switch_seen_ = false;
  bool has_temperature_ = false, has_switch_ = false;
};

}  // namespace spheretree::device
