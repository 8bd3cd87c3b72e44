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

TEST(Device, SlowMotionTakesTheSameStepsLessOften) {
  ReplayDevice device(test::somePoses(60));
  Answer renderer;
  device.start(renderer, {}, Clock::Stepped);
  ASSERT_TRUE(device.setPace(4));
  for (int period = 0; period < 40; ++period) EXPECT_TRUE(device.step());
  ASSERT_EQ(renderer.seen.size(), 10u);
  for (std::size_t n = 0; n < 10; ++n) EXPECT_NEAR(renderer.seen[n].time, static_cast<double>(n) * kServoPeriod, 1e-12);
  ASSERT_TRUE(device.setPace(0));
  for (int period = 0; period < 40; ++period) EXPECT_TRUE(device.step());
  EXPECT_EQ(renderer.seen.size(), 10u) << "a pause takes no step";
  for (int n = 0; n < 3; ++n) ASSERT_TRUE(device.stepOnce());
  for (int period = 0; period < 40; ++period) device.step();
  EXPECT_EQ(renderer.seen.size(), 13u);
  ASSERT_TRUE(device.setPace(1));
  while (device.step()) {
  }
  EXPECT_EQ(renderer.seen.size(), 60u);
  for (std::size_t n = 0; n < 60; ++n) EXPECT_EQ(renderer.seen[n].tick, n);
  EXPECT_EQ(device.status().late_ticks, 0u);
}

TEST(Device, APauseOfTheRealClockHasNoLength) {
  SimulatedDevice device({});
  Answer renderer;
  renderer.seen.reserve(100'000);
  device.start(renderer, {}, Clock::Real);
  const auto waitFor = [&](std::uint64_t ticks) {
    while (device.status().ticks < ticks) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  };
  waitFor(5);
  ASSERT_TRUE(device.setPace(0));
  std::this_thread::sleep_for(std::chrono::milliseconds(20));  // the step that runs now ends
  const std::uint64_t before = device.status().ticks, late = device.status().late_ticks;
  std::this_thread::sleep_for(std::chrono::milliseconds(600));
  EXPECT_EQ(device.status().ticks, before);
  ASSERT_TRUE(device.stepOnce());
  waitFor(before + 1);
  device.stop();
  ASSERT_EQ(renderer.seen.size(), before + 1);
  EXPECT_LT(renderer.seen[before].time - renderer.seen[before - 1].time, 0.3);
  EXPECT_LE(device.status().late_ticks, late + 1);
  EXPECT_EQ(device.status().phase, Phase::Stopped);
}

TEST(Device, ARestartIsAStart) {
  SimulatedSettings settings;
  settings.path = [](double t) { return Configuration{{5 * t, 0, -2 * t}, {1, 0, 0, 0}}; };
  SimulatedDevice device(settings);
  Answer renderer;
  renderer.answer = [](const DeviceState& state) { return Rendered{{{0, 0, -0.1 * state.handle.position.z()}, {0, 0, 0}}, 0, false}; };
  device.start(renderer, {}, Clock::Stepped);
  for (int n = 0; n < 300; ++n) device.step();
  ASSERT_TRUE(device.setPace(0));
  ASSERT_TRUE(device.restart());
  for (int n = 0; n < 10; ++n) device.step();
  ASSERT_EQ(renderer.seen.size(), 301u) << "the first step is taken in a pause, too";
  ASSERT_TRUE(device.setPace(1));
  for (int n = 1; n < 300; ++n) device.step();
  ASSERT_EQ(renderer.seen.size(), 600u);
  for (std::size_t n = 0; n < 300; ++n) {
    const DeviceState &first = renderer.seen[n], &again = renderer.seen[300 + n];
    ASSERT_EQ(first.handle.position, again.handle.position) << n;
    ASSERT_EQ(first.time, again.time);
    ASSERT_EQ(again.restarted, n == 0);
    ASSERT_FALSE(first.restarted);
  }
  EXPECT_EQ(device.status().ticks, 600u);
}

}  // namespace
}  // namespace spheretree::device
