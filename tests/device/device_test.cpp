// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/device.h"

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <thread>
#include <vector>

#include "scripted_renderer.h"
#include "spheretree/device/replay_device.h"
#include "spheretree/device/simulated_device.h"

namespace spheretree::device {
namespace {

using test::Answer;

DeviceFault faultOf(const std::function<void()>& act) {
  try {
    act();
  } catch (const DeviceError& error) {
    EXPECT_GT(std::string(error.what()).size(), 20u);
    return error.fault;
  }
  return DeviceFault::None;
}

TEST(Device, RefusesWhatItCannotDo) {
  Answer renderer;
  ReplayDevice device(test::somePoses(3));
  EXPECT_FALSE(device.step()) << "not started";
  SafetySettings bad;
  bad.max_force = 0;
  EXPECT_EQ(faultOf([&] { device.start(renderer, bad, Clock::Stepped); }), DeviceFault::Refused);
  device.start(renderer, {}, Clock::Stepped);
  EXPECT_EQ(faultOf([&] { device.start(renderer, {}, Clock::Stepped); }), DeviceFault::Refused);
  device.stop();
  device.stop();
  EXPECT_FALSE(device.step());
  EXPECT_EQ(renderer.seen.size(), 0u);
}

TEST(Device, RealClockKeepsAThousandStepsASecond) {
  SimulatedDevice device({});
  Answer renderer;
  renderer.seen.reserve(10'000);
  device.start(renderer, {}, Clock::Real);
  EXPECT_FALSE(device.step()) << "the device's own thread steps";
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  device.stop();
  const DeviceStatus status = device.status();
  EXPECT_EQ(status.phase, Phase::Stopped);
  EXPECT_EQ(status.ticks, renderer.seen.size());
  EXPECT_GE(status.ticks, 1u);
  // Never in a burst: the steps and their time agree, even on a busy machine.
  EXPECT_LE(static_cast<double>(status.ticks - 1) * kServoPeriod, renderer.seen.back().time + 2 * kServoPeriod);
  const std::size_t after = renderer.seen.size();
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(renderer.seen.size(), after) << "nothing is rendered after stop()";
}

TEST(Device, ARendererThatHangsSwitchesTheForcesOff) {
  SimulatedDevice device({});
  Answer renderer;
  renderer.seen.reserve(10'000);
  renderer.answer = [](const DeviceState& state) {
    if (state.tick == 20) std::this_thread::sleep_for(std::chrono::milliseconds(250));
    return Rendered{{{1, 0, 0}, {0, 0, 0}}, 0, false};
  };
  device.start(renderer, {}, Clock::Real);
  for (int n = 0; n < 2000 && device.status().ticks < 30; ++n) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  device.stop();
  EXPECT_GE(device.status().late_ticks, 1u);
  EXPECT_TRUE(device.status().safety & kForcesOff);
  EXPECT_EQ(device.actuated().force.norm(), 0);
}

TEST(Device, LimitsAreNarrowedToThoseOfTheDevice) {
  SimulatedSettings settings;
  settings.max_force = 1.5;
  settings.max_torque = {10, 10, 4};
  SimulatedDevice device(settings);
  Answer renderer;
  renderer.answer = [](const DeviceState&) { return Rendered{{{0, 0, 5}, {100, 0, 0}}, 0, false}; };
  SafetySettings safety;
  safety.start_guard = false;
  device.start(renderer, safety, Clock::Stepped);
  for (int n = 0; n < 100; ++n) device.step();
  EXPECT_NEAR(device.actuated().force.norm(), 1.5, 1e-3);
  EXPECT_NEAR(device.actuated().torque.norm(), 10, 0.01);
}

}  // namespace
}  // namespace spheretree::device
