// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/device.h"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <thread>
#include <vector>

#include "spheretree/device/emergency_stop.h"
#include "spheretree/device/replay_device.h"
#include "spheretree/device/simulated_device.h"
#include "support/random.h"

namespace spheretree::device {
namespace {

struct Answer final : Renderer {
  std::function<Rendered(const DeviceState&)> answer = [](const DeviceState&) { return Rendered(); };
  std::vector<DeviceState> seen;
  Rendered render(const DeviceState& state) noexcept override {
    seen.push_back(state);
    return answer(state);
  }
};

std::vector<Configuration> someposes(int count) {
  test::Random random(3);
  std::vector<Configuration> poses;
  for (int n = 0; n < count; ++n) poses.push_back({random.inCube(1), rotationOf(random.inCube(1))});
  return poses;
}

DeviceFault faultOf(const std::function<void()>& act) {
  try {
    act();
  } catch (const DeviceError& error) {
    EXPECT_GT(std::string(error.what()).size(), 20u);
    return error.fault;
  }
  return DeviceFault::None;
}

TEST(Device, ReplayGivesEveryPoseOnceAndEnds) {
  const std::vector<Configuration> poses = someposes(5);
  ReplayDevice device(poses);
  Answer renderer;
  for (int run = 0; run < 2; ++run) {  // a second run begins at the first pose again
    renderer.seen.clear();
    device.start(renderer, {}, Clock::Stepped);
    int steps = 0;
    while (device.step()) ++steps;
    EXPECT_EQ(steps, 5);
    EXPECT_EQ(device.status().phase, Phase::Ended);
    EXPECT_EQ(device.status().ticks, 5u);
    ASSERT_EQ(renderer.seen.size(), 5u);
    for (std::size_t n = 0; n < 5; ++n) {
      EXPECT_EQ(renderer.seen[n].tool.position, poses[n].position);
      EXPECT_EQ(renderer.seen[n].tool.orientation.coeffs(), poses[n].orientation.coeffs());
      EXPECT_EQ(renderer.seen[n].tick, n);
      EXPECT_DOUBLE_EQ(renderer.seen[n].time, static_cast<double>(n) * 1e-3);
    }
    device.stop();
    EXPECT_EQ(device.status().phase, Phase::Ended) << "stop() keeps the first reason";
  }
}

TEST(Device, RefusesWhatItCannotDo) {
  Answer renderer;
  EXPECT_EQ(faultOf([] { ReplayDevice({}); }), DeviceFault::Refused);
  ReplayDevice device(someposes(3));
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
  // Never in a burst: the steps and the time they claim agree, however busy the machine is.
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

TEST(EmergencyStop, EverySignalTakesTheForcesOffAtTheNextStep) {
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    EmergencyStop stop;
    SimulatedSettings settings;
    settings.coulomb = 0;
    SimulatedDevice device(settings);
    Answer renderer;
    renderer.answer = [](const DeviceState&) { return Rendered{{{1, 0, 0}, {0, 5, 0}}, 0, false}; };
    SafetySettings safety;
    safety.start_guard = false;
    device.start(renderer, safety, Clock::Stepped);
    for (int n = 0; n < 10; ++n) ASSERT_TRUE(device.step());
    EXPECT_GT(device.actuated().force.norm(), 0.9);
    EXPECT_FALSE(EmergencyStop::requested());
    ASSERT_EQ(std::raise(number), 0);
    EXPECT_TRUE(EmergencyStop::requested());
    EXPECT_EQ(EmergencyStop::signal(), number);
    device.step();
    EXPECT_EQ(device.actuated().force.norm(), 0);
    EXPECT_EQ(device.actuated().torque.norm(), 0);
    EXPECT_EQ(device.status().phase, Phase::Halted);
    EXPECT_FALSE(device.step()) << "it does not go on";
    EXPECT_TRUE(device.status().safety & kEmergencyStop);
  }
  EXPECT_FALSE(EmergencyStop::requested()) << "withdrawn with the last EmergencyStop";
}

TEST(EmergencyStop, RestoresTheFormerHandlers) {
  struct sigaction before, inside, after;
  sigaction(SIGTERM, nullptr, &before);
  {
    EmergencyStop stop;
    sigaction(SIGTERM, nullptr, &inside);
  }
  sigaction(SIGTERM, nullptr, &after);
  EXPECT_EQ(before.sa_handler, after.sa_handler);
  EXPECT_NE(before.sa_handler, inside.sa_handler);
}

TEST(EmergencyStop, StopsADeviceOnItsOwnClock) {
  EmergencyStop stop;
  SimulatedDevice device({});
  Answer renderer;
  renderer.seen.reserve(100'000);
  device.start(renderer, {}, Clock::Real);
  std::raise(SIGINT);
  for (int n = 0; n < 2000 && device.status().phase == Phase::Running; ++n) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(device.status().phase, Phase::Halted);
  device.stop();
}

}  // namespace
}  // namespace spheretree::device
