// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/linked_device.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <limits>
#include <thread>

#include "scripted_renderer.h"
#include "spheretree/device/clutch.h"
#include "stepped_link.h"

namespace spheretree::device {
namespace {

/// A link of which the test sets the state.
struct Scripted final : Link {
  LinkState now;
  bool is_new = true;
  std::vector<Wrench> sent;
  DeviceInfo info() const override { return {.model = "scripted", .serial = "", .driver = "", .can_step = can_step}; }
  bool read(LinkState& state) noexcept override {
    state = now;
    return is_new;
  }
  void send(const Wrench& wrench) noexcept override {
    if (can_step) sent.push_back(wrench);
    last_force = wrench.force.norm();
  }
  bool can_step = true;
  std::atomic<double> last_force{0};
};

TEST(LinkedDevice, AgeCountsTheStepsWithoutAPose) {
  auto link = std::make_unique<Scripted>();
  Scripted& script = *link;
  LinkedDevice device(std::move(link));
  test::Push push;
  SafetySettings settings = test::bareSafety();
  settings.period = 0.0005;
  device.start(push, settings, Clock::Stepped);
  device.step();
  EXPECT_EQ(push.last.age, 0);
  script.is_new = false;
  for (int n = 1; n <= 40; ++n) device.step();
  EXPECT_NEAR(push.last.age, 0.02, 1e-12);
  EXPECT_GT(script.sent.back().force.norm(), 2);
  for (int n = 0; n < 100; ++n) device.step();
  EXPECT_NEAR(script.sent.back().force.norm() / script.sent[10].force.norm(), 0.5, 0.01) << "half of the fade";
}

TEST(LinkedDevice, AClutchFreezesTheToolAndMovesItsOrigin) {
  auto link = std::make_unique<Scripted>();
  Scripted& script = *link;
  LinkedDevice device(std::move(link));
  test::Push push;
  SafetySettings settings = test::bareSafety();
  settings.clutch_buttons = 4;
  device.start(push, settings, Clock::Stepped);
  const auto at = [&](double x, std::uint32_t buttons) {
    script.now.handle.position = {x, 0, 0};
    script.now.buttons = buttons;
    device.step();
    return push.last.handle.position.x();
  };
  for (int n = 0; n < 20; ++n) EXPECT_EQ(at(n, 0), n);
  for (int n = 20; n > 5; --n) {
    EXPECT_EQ(at(n, 4), 20) << "the position when it was pressed";
    EXPECT_EQ(script.sent.back().force.norm(), 0) << "else the hand would carry the force along";
  }
  EXPECT_EQ(at(5, 0), 20);
  EXPECT_EQ(at(6, 0), 21);
  EXPECT_EQ(at(5, 2), 20) << "another button";
  EXPECT_EQ(at(4, 4), 19);
  script.now.handle.position.setConstant(std::numeric_limits<double>::quiet_NaN());
  device.step();
  EXPECT_EQ(at(3, 0), 19) << "a bad pose is forgotten";
}

TEST(LinkedDevice, AWeightIsCarriedOnlyWhileForcesAreOn) {
  auto link = std::make_unique<Scripted>();
  Scripted& script = *link;
  LinkedDevice device(std::move(link));
  test::Push push;
  push.wrench = {};
  SafetySettings settings;
  settings.carried_weight = 1.5;
  device.start(push, settings, Clock::Stepped);
  for (int n = 0; n < 2200; ++n) {
    device.step();
    const double before = n == 0 ? 0 : script.sent[script.sent.size() - 2].force.y();
    ASSERT_LE(std::abs(script.sent.back().force.y() - before), 0.01) << n;
  }
  EXPECT_NEAR(script.sent.back().force.y(), 1.5, 1e-12);
  push.wrench.force = {0, 30, 0};
  for (int n = 0; n < 100; ++n) device.step();
  EXPECT_NEAR(script.sent.back().force.y(), settings.max_force, 1e-12) << "together within the limits";
  script.now.buttons = 1;
  device.step();
  EXPECT_EQ(script.sent.back().force.norm(), 0);
}

TEST(LinkedDevice, APauseSendsZeroInEachPeriod) {
  auto link = std::make_unique<Scripted>();
  Scripted& script = *link;
  script.can_step = false;
  LinkedDevice device(std::move(link));
  test::Push push;
  device.start(push, test::bareSafety(), Clock::Real);
  const auto comes = [&](const std::function<bool()>& holds) {
    for (int n = 0; n < 5000 && !holds(); ++n) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return holds();
  };
  EXPECT_TRUE(comes([&] { return script.last_force > 2; }));
  EXPECT_FALSE(device.setPace(2)) << "a hand does not slow down";
  EXPECT_FALSE(device.stepOnce());
  EXPECT_FALSE(device.restart());
  EXPECT_TRUE(device.setPace(0));
  EXPECT_TRUE(comes([&] { return script.last_force == 0; }));
  device.setPace(1);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(script.last_force, 0) << "as after a release: the guard waits";
  device.stop();
}

TEST(LinkedDevice, TheLastStepsOfARunAreZero) {
  auto link = std::make_unique<Scripted>();
  Scripted& script = *link;
  LinkedDevice device(std::move(link));
  test::Push push;
  device.start(push, test::bareSafety(), Clock::Stepped);
  for (int n = 0; n < 10; ++n) device.step();
  script.now.failed = true;
  script.now.code = -5;
  device.step();
  EXPECT_EQ(device.status().phase, Phase::Failed);
  EXPECT_EQ(device.status().vendor_code, -5);
  ASSERT_GE(script.sent.size(), 14u);
  for (std::size_t n = 10; n < script.sent.size(); ++n) EXPECT_EQ(script.sent[n].force.norm(), 0);
}

}  // namespace
}  // namespace spheretree::device
