// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/emergency_stop.h"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "scripted_renderer.h"
#include "spheretree/device/simulated_device.h"

namespace spheretree::device {
namespace {

using test::Answer;

#ifdef SIGHUP
constexpr int kClosed = SIGHUP;  // the terminal was closed
#else
constexpr int kClosed = SIGBREAK;
#endif

auto handlerOf(int number) {
  const auto handler = std::signal(number, SIG_DFL);
  std::signal(number, handler);
  return handler;
}

TEST(EmergencyStop, EverySignalTakesTheForcesOffAtTheNextStep) {
  for (const int number : {SIGINT, SIGTERM, kClosed}) {
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
  const auto before = handlerOf(SIGTERM);
  {
    EmergencyStop stop;
    EXPECT_NE(handlerOf(SIGTERM), before);
  }
  EXPECT_EQ(handlerOf(SIGTERM), before);
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

TEST(EmergencyStop, IsWithdrawnOnlyWithTheLastOne) {
  EmergencyStop outer;
  {
    EmergencyStop inner;
    EmergencyStop::request();
    EXPECT_EQ(EmergencyStop::signal(), 0) << "no signal asked for it";
  }
  EXPECT_TRUE(EmergencyStop::requested()) << "the outer one still stands";
  EXPECT_NE(handlerOf(SIGINT), SIG_DFL) << "the inner one gave back the outer one's handler";
}

TEST(EmergencyStop, IsSeenFromAnotherThread) {
  EmergencyStop stop;
  std::thread([] { EmergencyStop::request(); }).join();
  EXPECT_TRUE(EmergencyStop::requested());
}

TEST(EmergencyStop, ADeviceThatStartsUnderItSendsNothing) {
  EmergencyStop stop;
  EmergencyStop::request();
  SimulatedDevice device({});
  Answer renderer;
  renderer.answer = [](const DeviceState&) { return Rendered{{{1, 0, 0}, {0, 0, 0}}, 0, false}; };
  SafetySettings safety;
  safety.start_guard = false;
  device.start(renderer, safety, Clock::Stepped);
  while (device.step()) ASSERT_EQ(device.actuated().force.norm(), 0);
  EXPECT_EQ(device.actuated().force.norm(), 0);
  EXPECT_EQ(device.status().phase, Phase::Halted);
}

}  // namespace
}  // namespace spheretree::device
