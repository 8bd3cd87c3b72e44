// SPDX-License-Identifier: Apache-2.0
#include "spheretree/servo/servo.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <thread>
#include <vector>

#include "spheretree/core/sphere_tree_codec.h"
#include "support/c_scene.h"
#include "support/shape_trees.h"

namespace spheretree {
namespace {

/// A ball of 5 mm over a ball of 20 mm whose top is at z = 0; the object belongs to body 1.
struct Servo : testing::Test {
  test::CScene c;
  st_servo* servo = nullptr;
  st_servo_snapshot now{};

  Servo() {
    now.struct_size = sizeof now;
    const std::vector<std::byte> tool = encodeSphereTree(test::oneBallTree(5)), object = encodeSphereTree(test::oneBallTree(20));
    const st_pose below{{0, 0, -20}, {1, 0, 0, 0}};
    EXPECT_EQ(st_scene_set_tool(c.scene, tool.data(), tool.size(), test::kOrigin), 0);
    EXPECT_EQ(st_scene_add_object(c.scene, object.data(), object.size(), &below), 0);
    EXPECT_EQ(st_scene_set_body(c.scene, 0, 1), 0);
  }
  ~Servo() override { st_servo_stop(servo); }

  /// Starts with the tool 10 mm above the object.
  void start(double rate = 1000, double timeout = 0.1) {
    st_servo_options options = ST_SERVO_OPTIONS_INIT;
    options.rate_hz = rate;
    options.engine_timeout_s = timeout;
    options.device_in_world.position_mm[2] = 15;
    servo = st_servo_start(c.scene, "simulated", &options);
    ASSERT_NE(servo, nullptr) << st_servo_error();
  }
  const st_servo_snapshot& state() {
    st_servo_state(servo, &now);
    return now;
  }
  /// Waits until it holds, at most 20 s.
  bool until(const std::function<bool()>& holds) {
    for (int n = 0; n < 10'000; ++n) {
      state();
      if (holds()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return false;
  }
  bool hand(double z) {
    const st_pose pose{{0, 0, z}, {1, 0, 0, 0}};
    return st_servo_move_hand(servo, &pose) == 0;
  }
  bool body(double z) {
    const st_pose pose{{0, 0, z}, {1, 0, 0, 0}};
    return st_servo_move_body(servo, 1, &pose) == 0;
  }
  double force() const { return now.wrench.force_n[2]; }
};

TEST_F(Servo, AHandPressesOnTheObject) {
  for (const double rate : {1000.0, 4000.0}) {
    start(rate);
    EXPECT_STREQ(st_servo_device(servo), "simulated device");
    EXPECT_EQ(st_servo_renders_torque(servo), 1);
    ASSERT_TRUE(until([&] { return now.step > 100 && !(now.safety & ST_SERVO_RAMP); })) << "guard and ramp end in free space";
    EXPECT_NEAR(now.haptic_tool.position_mm[2], 15, 0.1);
    EXPECT_EQ(now.phase, std::uint32_t{ST_SERVO_RUNNING});
    EXPECT_LE(static_cast<double>(now.step), now.time_s * rate + 2) << "no steps in a burst after one that was late";
    if (now.late_steps == 0) {
      EXPECT_LE(now.time_s * rate, 2 * static_cast<double>(now.step)) << "the rate, unless the machine is busy";
    }
    ASSERT_TRUE(hand(0));
    ASSERT_TRUE(until([&] { return force() > 0.5 && now.contacts > 0; }));
    st_contact contact[2] = {ST_CONTACT_INIT, ST_CONTACT_INIT};
    EXPECT_GE(st_servo_contacts(servo, contact, 2), 1u);
    EXPECT_GT(contact[0].normal[2], 0.9);
    EXPECT_NEAR(now.graphic_tool.position_mm[2], 5, 0.3) << "on the object";
    EXPECT_LT(now.haptic_tool.position_mm[2], now.graphic_tool.position_mm[2]);
    st_servo_stop(servo);
    servo = nullptr;
  }
}

TEST_F(Servo, AMovedBodyLiftsTheTool) {
  start();
  ASSERT_TRUE(until([&] { return now.step > 100 && !(now.safety & ST_SERVO_RAMP); }));
  double last = now.graphic_tool.position_mm[2];
  for (int picture = 0; picture <= 60; ++picture) {  // an engine at 60 Hz, 10 mm too far up
    ASSERT_TRUE(body(20.0 * picture / 60));
    std::this_thread::sleep_for(std::chrono::milliseconds(16));
    last = state().graphic_tool.position_mm[2];
  }
  EXPECT_GT(last, 20);
  EXPECT_GT(force(), 0.5);
}

/// F20: the engine stops for a second and returns.
TEST_F(Servo, APausedEngineFadesAndReturnsWithoutAKick) {
  start(1000, 0.05);
  ASSERT_TRUE(body(0));
  ASSERT_TRUE(until([&] {
    body(0);
    return now.step > 100 && !(now.safety & ST_SERVO_RAMP);
  }));
  ASSERT_TRUE(hand(0));
  ASSERT_TRUE(until([&] {
    body(0);
    return force() > 0.5;
  }));
  const double pressed = now.haptic_tool.position_mm[2];
  ASSERT_TRUE(until([&] { return (now.safety & ST_SERVO_FORCES_OFF) != 0; })) << "nothing moves the body for a second";
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  EXPECT_LT(state().haptic_tool.position_mm[2], pressed - 0.5) << "nothing holds the hand back";
  ASSERT_TRUE(body(0));
  ASSERT_TRUE(until([&] {
    body(0);
    return !(now.safety & ST_SERVO_FORCES_OFF);
  }));
  EXPECT_TRUE(now.safety & ST_SERVO_START_GUARD) << "the tool is inside: forces wait until it is free";
  ASSERT_TRUE(hand(15));
  ASSERT_TRUE(until([&] {
    body(0);
    return (now.safety & (ST_SERVO_START_GUARD | ST_SERVO_RAMP)) == ST_SERVO_RAMP;
  }));
}

TEST_F(Servo, AnEngineThatMovesNothingMayPause) {
  start(1000, 0.001);
  ASSERT_TRUE(until([&] { return now.step > 100 && !(now.safety & ST_SERVO_RAMP); }));
  hand(0);
  ASSERT_TRUE(until([&] { return force() > 0.5; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  EXPECT_FALSE(state().safety & ST_SERVO_FORCES_OFF);
}

TEST_F(Servo, SaysWhatIsWrong) {
  const auto error = [&](const char* device, const std::function<void(st_servo_options&)>& change) -> std::string {
    st_servo_options options = ST_SERVO_OPTIONS_INIT;
    change(options);
    st_servo* const started = st_servo_start(c.scene, device, &options);
    if (!started) return st_servo_error();
    st_servo_stop(started);
    return {};
  };
  const auto same = [](st_servo_options&) {};
  EXPECT_NE(error("mouse", same).find("there is no device 'mouse'"), std::string::npos);
  EXPECT_NE(error("haply", [](auto& o) { o.address = "127.0.0.1:1"; }).find("Start the Haply Inverse Service"), std::string::npos);
  EXPECT_NE(error("net:10.0.0.1:5", same).find("is another machine"), std::string::npos);
  EXPECT_NE(error("dhd", [](auto& o) { o.library = "/nowhere.so"; }).find("/nowhere.so"), std::string::npos);
  EXPECT_NE(error("simulated", [](auto& o) { o.rate_hz = 100; }).find("rate_hz"), std::string::npos);
  EXPECT_NE(error("simulated", [](auto& o) { o.max_force_n = 0; }).find("max_force_n"), std::string::npos);
  EXPECT_NE(error("simulated", [](auto& o) { o.tool_on_handle.orientation_wxyz[0] = 0; }).find("tool_on_handle"), std::string::npos);
  EXPECT_EQ(error("simulated", same), "");
  EXPECT_EQ(st_servo_start(nullptr, "simulated", nullptr), nullptr);
  test::CScene empty;
  EXPECT_EQ(st_servo_start(empty.scene, "simulated", nullptr), nullptr);
  EXPECT_STRNE(st_servo_error(), "");
  start();
  EXPECT_FALSE(hand(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_FALSE(body(std::numeric_limits<double>::infinity()));
  const st_pose pose{{0, 0, 0}, {1, 0, 0, 0}};
  EXPECT_EQ(st_servo_move_body(servo, 0, &pose), -1);
  EXPECT_EQ(st_servo_move_body(servo, 7, &pose), 0);
  EXPECT_TRUE(until([&] { return st_servo_move_body(servo, 7, &pose) == -1; })) << "the scene has no body 7";
  st_servo_stop(nullptr);
}

/// A program of an earlier version has shorter structures: nothing beyond their ends is touched.
TEST_F(Servo, StructuresMayBeShorter) {
  start();
  ASSERT_TRUE(until([&] { return now.step > 0; }));
  struct {
    st_servo_snapshot state;
    double behind = 7;
  } old;
  old.state.struct_size = offsetof(st_servo_snapshot, wrench);
  old.state.wrench.force_n[0] = 42;
  st_servo_state(servo, &old.state);
  EXPECT_GT(old.state.step, 0u);
  EXPECT_EQ(old.state.wrench.force_n[0], 42);
  EXPECT_EQ(old.behind, 7);
}

}  // namespace
}  // namespace spheretree
