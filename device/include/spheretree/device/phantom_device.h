// SPDX-License-Identifier: Apache-2.0
// A Phantom device through the vendor's HDAPI (OpenHaptics 3). The library is loaded at run time, so that a build needs
// nothing from the vendor. Conventions, order of calls, first use with hardware: docs/device.md
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "spheretree/device/device.h"

namespace spheretree::device {

struct HdApi;

/// How a device interprets its torque. A program cannot detect this: try Cartesian with 10 N mm first.
enum class TorqueConvention : std::uint8_t {
  Cartesian,  // HD_CURRENT_TORQUE: vector in device axes
  Gimbal,     // HD_CURRENT_GIMBAL_TORQUE: about the yaw, pitch and roll joint; orientation of the handle to its base: Ry(yaw) Rx(pitch)
              // Rz(roll)
};

struct PhantomSettings {
  std::string library;  // path of the vendor's library; empty: libHD.so or one of its known versions, on the loader's path
  std::string device;   // name in the vendor's configuration; empty: the first device, else "Default PHANToM", else "Default Device"
  TorqueConvention torque = TorqueConvention::Cartesian;
  bool calibrate = false;  // calibrate now, with the arm in its reset pose (devices with encoder reset, once after power-up)
  std::string vendor, application, password;  // of a deployment licence, if `vendor` is not empty
};

class PhantomDevice final : public Device {
 public:
  /// Loads the library, opens the device and checks its calibration; the forces stay off. Only one instance in a
  /// process.
  /// @throws DeviceError LibraryMissing (with the loader's message for each place searched), SymbolMissing, NotFound,
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
