// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/linked_device.h"

#include <utility>

namespace spheretree::device {

LinkedDevice::LinkedDevice(std::unique_ptr<Link> link) : link_(std::move(link)) { info_ = link_->info(); }

void LinkedDevice::begin(Clock) {
  if (state_.failed) throw DeviceError(DeviceFault::Communication, info_.model + " lost its connection: open the device again");
  silent_steps_ = 0;
  link_->begin();
}

bool LinkedDevice::advance() noexcept {
  silent_steps_ = link_->read(state_) ? 0 : silent_steps_ + 1;
  DeviceState state;
  state.handle = state_.handle;
  state.buttons = state_.buttons;
  state.released = state_.released;
  state.temperature = state_.temperature;
  state.failed = state_.failed;
  state.age = static_cast<double>(silent_steps_) * period();
  if (state_.code != 0) note(state_.code);
  link_->send(tick(state));
  if (state_.failed) finish(Phase::Failed, DeviceFault::Communication, state_.code);
  if (status().phase != Phase::Running) sendZeros();  // this was the last step
  return true;
}

void LinkedDevice::end() noexcept {
  sendZeros();
  link_->end();
}

/// Several times, since a message may get lost.
void LinkedDevice::sendZeros() noexcept {
  for (int n = 0; n < 3; ++n) link_->send({});
}

}  // namespace spheretree::device
