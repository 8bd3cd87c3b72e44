// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/safety.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "support/random.h"

namespace spheretree::device {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

/// An own servo loop, 1 ms for each step.
struct Rig {
  SafetySettings settings;
  Safety safety;
  DeviceState state;
  Rendered rendered;
  Wrench sent;

  explicit Rig(const SafetySettings& s = {}) : settings(s), safety(s) {}
  const Wrench& step(double time = kServoPeriod) {
    state.time += time;
    ++state.tick;
    return sent = safety.limit(state, rendered);
  }
  double force() const { return sent.force.norm(); }
  bool on(SafetyEvent event) const { return safety.events() & event; }
  void ask(double force, double torque = 0) { rendered = {{{force, 0, 0}, {torque, 0, 0}}, 0, false}; }
  /// Steps until the requested wrench arrives undiminished.
  Rig& settle(double force = 2, double torque = 0) {
    ask(0);
    for (int n = 0; n < 20; ++n) step();
    ask(force, torque);
    for (int n = 0; n < 5000 && (this->force() < force || sent.torque.norm() < torque); ++n) step();
    EXPECT_NEAR(this->force(), force, 1e-12);
    return *this;
  }
  bool isZero() const { return sent.force.norm() == 0 && sent.torque.norm() == 0; }
};

TEST(Safety, ForceIsShortenedAndKeepsItsDirection) {
  Rig rig;
  rig.settle(1);
  rig.rendered.wrench.force = {30, 40, 0};
  for (int n = 0; n < 100; ++n) rig.step();
  EXPECT_NEAR(rig.force(), 8, 1e-12);
  EXPECT_NEAR(rig.sent.force.x() / rig.sent.force.y(), 0.75, 1e-12);
  EXPECT_TRUE(rig.on(kForceClamped));
}

TEST(Safety, TorqueIsLimitedAboutEachAxisOfTheHandle) {
  Rig rig;
  rig.settle(1);
  rig.rendered.wrench.torque = {0, 0, 480};  // ten times the roll limit: about the handle's z axis, while it is upright
  for (int n = 0; n < 100; ++n) rig.step();
  EXPECT_NEAR(rig.sent.torque.z(), 48, 1e-9);
  EXPECT_TRUE(rig.on(kTorqueClamped));
  rig.state.handle.orientation = rotationOf({M_PI / 2, 0, 0});  // now about the handle's y
  for (int n = 0; n < 100; ++n) rig.step();
  EXPECT_NEAR(rig.sent.torque.z(), 188, 1e-9);
}

TEST(Safety, RisesSlowlyAndFallsAtOnce) {
  Rig rig;
  rig.settle(1);
  rig.ask(5);
  const double before = rig.force();
  rig.step();
  EXPECT_NEAR(rig.force() - before, 0.5, 1e-12);
  EXPECT_TRUE(rig.on(kSlewLimited));
  for (int n = 0; n < 20; ++n) rig.step();
  rig.ask(-5);  // a reversal: down to zero at once, up again at the slew rate
  rig.step();
  EXPECT_NEAR(rig.sent.force.x(), -0.5, 1e-12);
  rig.ask(0);
  rig.step();
  EXPECT_TRUE(rig.isZero()) << "leaving a contact is not delayed";
}

TEST(Safety, AContactAfterARestMayRiseFasterAFlickerMayNot) {
  Rig rig;
  rig.settle(1);
  rig.ask(0);
  for (int n = 0; n < 30; ++n) rig.step();
  rig.ask(3);
  rig.step();
  EXPECT_NEAR(rig.force(), 3, 1e-12);
  rig.ask(0);
  rig.step();
  rig.ask(3);
  rig.step();
  EXPECT_NEAR(rig.force(), 0.5, 1e-12);
}

TEST(Safety, StartsAtZeroAndThenRampsForTwoSeconds) {
  Rig rig;
  rig.ask(7);  // begun in contact
  for (int n = 0; n < 1000; ++n) {
    rig.step();
    ASSERT_TRUE(rig.isZero());
    ASSERT_TRUE(rig.on(kStartGuard));
  }
  rig.ask(0.19);
  for (int n = 0; n < 3; ++n) {
    rig.step();
    ASSERT_TRUE(rig.isZero()) << "more than three steps, not three";
  }
  rig.step();
  EXPECT_FALSE(rig.on(kStartGuard));
  EXPECT_TRUE(rig.on(kRamp));
  rig.ask(7);
  double last = rig.force();
  for (int n = 1; n < 1990; ++n) {
    rig.step();
    ASSERT_LE(rig.force() - last, 0.05 + 1e-12);
    ASSERT_LE(rig.force(), 7 * (n + 1) / 2000. + 1e-9);
    last = rig.force();
  }
  for (int n = 0; n < 20; ++n) rig.step();
  EXPECT_NEAR(rig.force(), 7, 1e-12);
}

TEST(Safety, AContactThatFlickersNeverPassesTheGuard) {
  Rig rig;
  for (int n = 0; n < 1000; ++n) {
    rig.ask(n % 4 == 3 ? 1 : 0);  // three calm steps in a row, never four
    rig.step();
    ASSERT_TRUE(rig.on(kStartGuard));
  }
}

TEST(Safety, TorqueAloneHoldsTheGuardToo) {
  Rig rig;
  rig.ask(0, 6);
  for (int n = 0; n < 100; ++n) rig.step();
  EXPECT_TRUE(rig.on(kStartGuard));
}

TEST(Safety, StaleContactsFadeAndThenSwitchOff) {
  Rig rig;
  rig.settle(2);
  for (int age = 1; age <= 20; ++age) {
    rig.rendered.model_age = age * 1e-3;
    rig.step();
    ASSERT_NEAR(rig.force(), 2, 1e-12) << "20 ms are allowed";
  }
  for (int age = 21; age <= 200; ++age) {
    rig.rendered.model_age = age * 1e-3;
    rig.step();
    ASSERT_TRUE(rig.on(kStaleModel));
    ASSERT_NEAR(rig.force(), 2 * std::max(0.0, 1 - (age - 20) / 100.), 1e-9);
    ASSERT_FALSE(rig.on(kForcesOff));
  }
  rig.rendered.model_age = 0.201;
  rig.step();
  EXPECT_TRUE(rig.on(kForcesOff));
  rig.rendered.model_age = 0;
  for (int n = 0; n < 5000; ++n) {
    rig.step();
    ASSERT_TRUE(rig.isZero()) << "only a person brings the forces back";
  }
  rig.safety.rearm();
  rig.step();
  EXPECT_TRUE(rig.on(kStartGuard)) << "still in contact: not yet";
  rig.settle(2);
}

TEST(Safety, FreshContactsComeBackWithoutAStep) {
  Rig rig;
  rig.settle(8);
  rig.rendered.model_age = 0.13;
  rig.step();
  EXPECT_TRUE(rig.isZero());
  rig.rendered.model_age = 0;
  double last = 0;
  for (int n = 0; n < 2100; ++n) {
    rig.step();
    ASSERT_LE(rig.force() - last, 0.05 + 1e-12);
    last = rig.force();
  }
  EXPECT_NEAR(last, 8, 1e-12);
}

TEST(Safety, APausedServoCountsAsOldContacts) {
  for (const double pause : {0.1, 0.5}) {
    Rig rig;
    rig.settle(6);
    rig.step(pause);  // a debugger, or a machine that swaps memory
    EXPECT_TRUE(rig.on(kStaleModel));
    EXPECT_LT(rig.force(), 6 * 0.21);
    EXPECT_EQ(rig.on(kForcesOff), pause > 0.2);
    double last = rig.force();
    for (int n = 0; n < 3000; ++n) {
      rig.step();
      ASSERT_LE(rig.force() - last, 0.1);
      last = rig.force();
    }
    EXPECT_EQ(last > 5.9, pause < 0.2);
  }
}

TEST(Safety, ButtonOrNoHandIsZeroAtOnceAndComesBackByTheRamp) {
  for (const bool button : {true, false}) {
    Rig rig;
    rig.settle(3, 20);
    (button ? rig.state.buttons = 1 : rig.state.released = true);
    rig.step();
    EXPECT_TRUE(rig.isZero());
    EXPECT_TRUE(rig.on(kReleased));
    rig.state.buttons = 0;
    rig.state.released = false;
    rig.step();
    EXPECT_TRUE(rig.on(kStartGuard));
    rig.settle(3);
  }
  Rig rig;
  rig.settle(3);
  rig.state.buttons = 2;  // not a release button
  rig.step();
  EXPECT_NEAR(rig.force(), 3, 1e-12);
}

TEST(Safety, FastAndStrongFades) {
  Rig rig;
  rig.settle(4);
  double last = rig.force();
  for (int n = 0; n < 60; ++n) {
    rig.state.handle.position.x() += 1.5;  // 1.5 m/s
    rig.step();
    ASSERT_TRUE(rig.on(kTooFast));
    ASSERT_LE(rig.force(), last);
    last = rig.force();
  }
  EXPECT_EQ(last, 0);
  Rig slow;
  slow.settle(4);
  for (int n = 0; n < 60; ++n) {
    slow.state.handle.position.x() += 0.9;
    slow.step();
  }
  EXPECT_NEAR(slow.force(), 4, 1e-12);
  Rig weak;
  weak.settle(0.9);
  for (int n = 0; n < 60; ++n) {
    weak.state.handle.position.x() += 1.5;
    weak.step();
  }
  EXPECT_NEAR(weak.force(), 0.9, 1e-12);
}

TEST(Safety, WarmMotorsBringTheLimitDownToTheContinuousOneAndCoolOnesBack) {
  Rig rig;
  rig.settle(8);
  rig.state.temperature = 0.71;
  rig.step();
  EXPECT_NEAR(rig.force(), 8 * 0.999, 1e-9);
  EXPECT_TRUE(rig.on(kWarmMotors));
  rig.state.temperature = 0.6;  // between the limits: continues to fall
  for (int n = 0; n < 3000; ++n) rig.step();
  EXPECT_NEAR(rig.force(), 3, 1e-9) << "the continuous force, not less";
  rig.state.temperature = 0.49;
  for (int n = 0; n < 3000; ++n) rig.step();
  EXPECT_NEAR(rig.force(), 8, 1e-9);
}

TEST(Safety, AFailedAnswerIsHeldForFiveMillisecondsAndThenFades) {
  for (int kind = 0; kind < 4; ++kind) {
    Rig rig;
    rig.settle(2, 10);
    if (kind == 0) rig.rendered.failed = true;
    if (kind == 1) rig.rendered.wrench.force.y() = kNan;
    if (kind == 2) rig.rendered.wrench.torque.z() = kInf;
    if (kind == 3) rig.rendered = {{{5, 5, 5}, {9, 9, 9}}, 0, true};  // a failed answer is not used, even if it looks valid
    for (int n = 1; n <= 104; ++n) {
      rig.step();
      ASSERT_TRUE(rig.on(kRendererFailed));
      ASSERT_NEAR(rig.sent.force.x(), 2 * (n <= 5 ? 1 : 1 - (n - 5) / 100.), 1e-9) << n;
      ASSERT_EQ(rig.sent.force.y(), 0);
    }
    for (int n = 0; n < 100; ++n) rig.step();
    EXPECT_TRUE(rig.isZero());
    EXPECT_TRUE(rig.on(kForcesOff));
  }
}

TEST(Safety, ADeviceFaultIsZeroForTheRestOfTheRun) {
  for (const bool halted : {false, true}) {
    Rig rig;
    rig.settle(2, 10);
    if (halted) rig.safety.emergencyStop();
    rig.state.failed = !halted;
    rig.step();
    EXPECT_TRUE(rig.isZero());
    rig.state.failed = false;
    rig.ask(0);
    rig.safety.rearm();
    for (int n = 0; n < 5000; ++n) {
      rig.step();
      ASSERT_TRUE(rig.isZero());
      ASSERT_TRUE(rig.on(halted ? kEmergencyStop : kDeviceFailed));
      if (n == 100) rig.ask(1);
    }
  }
}

TEST(Safety, ACalibrationJumpBeginsAnew) {
  Rig rig;
  rig.settle(2);
  rig.state.handle.position.y() += 20;
  rig.ask(20);
  rig.step();
  EXPECT_TRUE(rig.isZero());
  EXPECT_TRUE(rig.on(kBadPose));
  rig.step();
  EXPECT_TRUE(rig.on(kStartGuard));
  rig.settle(2);
  rig.state.handle.orientation.w() = kNan;
  rig.step();
  EXPECT_TRUE(rig.isZero());
}

/// For any input: bit patterns, pauses, jumps, faults. 10^6 steps, of them 2 * 10^5 with other settings.
/// SPHERETREE_LONG=1: 10^7.
TEST(Safety, NoInputSendsMoreThanTheLimits) {
  spheretree::test::Random random(7);
  const auto hostile = [&](double scale) {
    switch (random.below(8)) {
      case 0:
        return kNan;
      case 1:
        return random.unit() < 0.5 ? kInf : -kInf;
      case 2:
        return std::bit_cast<double>((static_cast<std::uint64_t>(random.below(1u << 31)) << 33) ^ random.below(1u << 31));
      case 3:
        return 0.0;
      default:
        return random.between(-scale, scale);
    }
  };
  const auto mostly = [&](double scale) { return random.below(100) == 0 ? hostile(scale) : random.between(-scale, scale); };
  const long steps = std::getenv("SPHERETREE_LONG") ? 10'000'000 : 1'000'000;
  long moved = 0;
  Rig rig;
  double heat = 0;
  for (long n = 0; n < steps; ++n) {
    if (n % 5000 == 0) {
      SafetySettings s;
      if (n % 10'000 == 0) {
        s.max_force = random.between(0.01, 22);
        s.max_torque = random.inBox({1, 1, 1}, {515, 515, 170});
        s.continuous_force = random.between(0.01, 30);
        s.start_guard = random.below(2) == 0;
        s.force_slew = s.torque_slew = random.between(0.01, 1000);
        s.ramp = random.between(0.001, 1);
        s.ramp_force_slew = s.ramp_torque_slew = random.between(0.01, 100);
      }
      ASSERT_EQ(findFault(s), "");
      rig = Rig(s);
    }
    const bool wild = n / 1000 % 2 == 1;  // half of the steps are sane enough to render
    const auto number = [&](double scale) { return wild ? hostile(scale) : mostly(scale); };
    rig.rendered.wrench.force = {number(30), number(30), number(30)};
    rig.rendered.wrench.torque = {number(900), number(900), number(900)};
    if (n / 500 % 2 == 0) rig.rendered.wrench = {0.001 * rig.rendered.wrench.force, 0.001 * rig.rendered.wrench.torque};
    rig.rendered.model_age = wild && random.below(20) == 0 ? hostile(0.3) : random.between(0, 0.03);
    rig.rendered.failed = random.below(200) == 0;
    rig.state.handle.position = wild ? Eigen::Vector3d(number(1e8), number(1e8), number(1e8)) : random.inCube(0.7);
    rig.state.handle.orientation = {number(1), number(1), number(1), number(1)};
    rig.state.buttons = random.below(1000) == 0 ? 1 : 0;
    rig.state.temperature = heat = random.below(1000) == 0 ? hostile(1) : heat;
    if (random.below(50) == 0) rig.safety.rearm();
    rig.step(wild && random.below(50) == 0 ? hostile(1) : kServoPeriod);
    if (!std::isfinite(rig.state.time)) rig.state.time = 0;
    ASSERT_TRUE(rig.sent.force.allFinite() && rig.sent.torque.allFinite()) << n;
    ASSERT_LE(rig.force(), rig.settings.max_force * (1 + 1e-12)) << n;
    if (!rig.isZero()) {
      ++moved;
      const Eigen::Vector3d torque = rig.state.handle.orientation.normalized().conjugate() * rig.sent.torque;
      for (int k = 0; k < 3; ++k) ASSERT_LE(std::abs(torque[k]), rig.settings.max_torque[k] * (1 + 1e-12)) << n;
    }
  }
  EXPECT_GT(moved, steps / 50) << "most steps were refused: the test looks away";
}

TEST(Safety, SettingsOutOfRangeAreNamed) {
  EXPECT_EQ(findFault({}), "");
  const auto fault = [](auto change) {
    SafetySettings s;
    change(s);
    return findFault(s);
  };
  EXPECT_EQ(fault([](auto& s) { s.max_force = 0; }), "max_force is 0: give a number from 1e-09 to 1e+06");
  EXPECT_NE(fault([](auto& s) { s.max_torque.y() = kNan; }).find("max_torque y"), std::string::npos);
  EXPECT_NE(fault([](auto& s) { s.cool = 0.8; }).find("cool"), std::string::npos);
  EXPECT_NE(fault([](auto& s) { s.ramp = 0; }).find("ramp"), std::string::npos);
  EXPECT_NE(fault([](auto& s) { s.stale_after = -1; }).find("stale_after"), std::string::npos);
}

}  // namespace
}  // namespace spheretree::device
