// SPDX-License-Identifier: Apache-2.0
// A device whose poses are given in advance; its wrench is not felt by anyone.
#pragma once

#include <vector>

#include "spheretree/device/device.h"

namespace spheretree::device {

class ReplayDevice final : public Device {
 public:
  /// One pose for each servo step, as formats::readTrajectory() reads them. The renderer receives them bit for bit.
  /// @throws DeviceError Refused if there is no pose.
  explicit ReplayDevice(std::vector<Configuration> poses);
  ~ReplayDevice() override { stop(); }

 private:
  void begin(Clock) override { next_ = 0; }
  void rewind() noexcept override { next_ = 0; }
  bool advance() noexcept override;

  std::vector<Configuration> poses_;
  std::size_t next_ = 0;
};

}  // namespace spheretree::device
