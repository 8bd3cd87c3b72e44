// SPDX-License-Identifier: Apache-2.0
// The controls of the stand-in for libHD, and a fixture round the device that loads it.
#pragma once

#include <gtest/gtest.h>

#include "../opened_library.h"
#include "fake_libhd.h"
#include "spheretree/device/phantom_device.h"

namespace spheretree::device {

/// The controls of the fake, from the same copy of it that the device loads.
struct Fake {
  void* library = test::opened(FAKE_LIBHD);
#define CONTROL(name) decltype(&::fake_##name) name = reinterpret_cast<decltype(&::fake_##name)>(test::found(library, "fake_" #name))
  CONTROL(reset);
  CONTROL(step);
  CONTROL(inject);
  CONTROL(set);
  CONTROL(ticks);
  CONTROL(record);
  CONTROL(violations);
  CONTROL(calls);
  CONTROL(running);
#undef CONTROL
  template <class Function>
  Function* hd(const char* name) const {
    return reinterpret_cast<Function*>(test::found(library, name));
  }
};

inline const Fake& fake() {
  static const Fake controls;
  return controls;
}

/// The fake's defaults and no safety rules: no guard, no slew limit, unless a test is about them.
struct PhantomDevice_ : testing::Test {
  FakeSettings settings;
  PhantomSettings phantom;
  SafetySettings safety;

  PhantomDevice_() {
    phantom.library = FAKE_LIBHD;
    safety.start_guard = false;
    safety.force_slew = safety.torque_slew = 1e6;
    safety.stale_after = safety.off_after = 1e6;  // time is virtual, but the pauses of a busy machine are real
    fake().reset(&settings);
  }
  void TearDown() override { EXPECT_STREQ(fake().violations(), ""); }
  void reset() { fake().reset(&settings); }
  DeviceError failure() {
    try {
      PhantomDevice device(phantom);
    } catch (const DeviceError& error) {
      return error;
    }
    return {DeviceFault::None, "it opened"};
  }
};

struct Constant final : Renderer {
  Wrench wrench{{1, -2, 0.5}, {10, 20, -5}};
  DeviceState last;
  long calls = 0;
  Rendered render(const DeviceState& state) noexcept override {
    last = state;
    ++calls;
    return {wrench, 0, false};
  }
};

inline Eigen::Vector3d asked(long tick) { return Eigen::Vector3d(fake().record(tick).asked); }
inline Eigen::Vector3d askedTorque(long tick) { return Eigen::Vector3d(fake().record(tick).asked_torque); }

}  // namespace spheretree::device
