// SPDX-License-Identifier: Apache-2.0
// Lets a test step a device that people hold, and keeps what was sent to it.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "spheretree/device/linked_device.h"

namespace spheretree::device::test {

class SteppedLink final : public Link {
 public:
  SteppedLink(std::unique_ptr<Link> link, std::vector<Wrench>* sent = nullptr) : link_(std::move(link)), sent_(sent) {}
  DeviceInfo info() const override {
    DeviceInfo info = link_->info();
    info.can_step = true;
    return info;
  }
  void begin() override { link_->begin(); }
  bool read(LinkState& state) noexcept override { return link_->read(state); }
  void send(const Wrench& wrench) noexcept override {
    if (sent_ && sent_->size() < sent_->capacity()) sent_->push_back(wrench);
    link_->send(wrench);
  }
  void end() noexcept override { link_->end(); }

 private:
  std::unique_ptr<Link> link_;
  std::vector<Wrench>* sent_;
};

/// A constant wrench.
struct Push final : Renderer {
  Wrench wrench{{1, -2, 0.5}, {10, 20, -5}};
  DeviceState last;
  Rendered render(const DeviceState& state) noexcept override {
    last = state;
    return {wrench, 0, false};
  }
};

/// No guard, ramp or slew limit, for tests that are about other rules.
inline SafetySettings bareSafety() {
  SafetySettings s;
  s.start_guard = false;
  s.force_slew = s.torque_slew = 1e6;
  return s;
}

}  // namespace spheretree::device::test
