// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/replay_device.h"

#include <utility>

namespace spheretree::device {

ReplayDevice::ReplayDevice(std::vector<Configuration> poses) : poses_(std::move(poses)) {
  if (poses_.empty()) throw DeviceError(DeviceFault::Refused, "replay: the trajectory has no pose: give at least one row");
  info_.model = "replay";
}

bool ReplayDevice::advance() noexcept {
  if (next_ == poses_.size()) return false;
  DeviceState state;
  state.handle = poses_[next_++];
  tick(state);
  return true;
}

}  // namespace spheretree::device
