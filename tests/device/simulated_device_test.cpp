// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/simulated_device.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdio>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "press.h"

namespace spheretree::device {
namespace {

constexpr Hand kNoHand{"none", 0, 0, 0, 0, 0, 0};

/// No friction, no encoder steps, no hand: the remaining model has closed forms.
SimulatedSettings bare() {
  SimulatedSettings s;
  s.viscous = s.viscous_rotation = s.coulomb = s.coulomb_rotation = s.position_step = 0;
  s.angle_step.setZero();
  s.hand = kNoHand;
  s.max_torque = {20, 20, 20};  // a fine 16-bit command
  return s;
}

struct Law final : Renderer {
  std::function<Wrench(const DeviceState&)> wrench = [](const DeviceState&) { return Wrench(); };
  std::vector<DeviceState> seen;
  Rendered render(const DeviceState& state) noexcept override {
    seen.push_back(state);
    return {wrench(state), 0, false};
  }
};

Law constantly(const Wrench& wrench) {
  Law law;
  law.wrench = [wrench](const DeviceState&) { return wrench; };
  return law;
}

void run(SimulatedDevice& device, Renderer& renderer, int steps) {
  device.start(renderer, spheretree::test::noSafety(), Clock::Stepped);
  for (int n = 0; n < steps; ++n) device.step();
}

TEST(SimulatedDevice, AConstantForceAgainstViscousFrictionFollowsItsExponential) {
  SimulatedSettings s = bare();
  s.viscous = 2;
  SimulatedDevice device(s);
  Law law = constantly({{0, 1, 0}, {0, 0, 0}});
  run(device, law, 100);
  const double tau = s.mass / s.viscous;
  EXPECT_NEAR(device.trueVelocity().y(), 500 * (1 - std::exp(-0.1 / tau)), 0.5);  // [mm/s] of 1 N / 2 N s/m
  EXPECT_NEAR(device.truePose().position.y(), 500 * (0.1 - tau * (1 - std::exp(-0.1 / tau))), 0.05);
}

TEST(SimulatedDevice, CoulombFrictionSticksBelowAndStopsWhatMoves) {
  SimulatedSettings s = bare();
  s.coulomb = 0.2;
  {
    SimulatedDevice device(s);
    Law law = constantly({{0.19, 0, 0}, {0, 0, 0}});
    run(device, law, 1000);
    EXPECT_EQ(device.truePose().position.x(), 0) << "sticks to the bit";
  }
  SimulatedDevice device(s);
  Law law;
  law.wrench = [](const DeviceState& state) { return Wrench{{state.tick < 50 ? 1.0 : 0.0, 0, 0}, {0, 0, 0}}; };
  run(device, law, 1000);
  // 50 ms at (1 - 0.2) N, then 0.2 N brakes: the distances are v^2/2a and v^2/2b.
  const double speed = 0.8 / s.mass * 0.05 * 1000,
               way = speed * speed / 2 / (0.8 / s.mass * 1000) + speed * speed / 2 / (0.2 / s.mass * 1000);
  EXPECT_NEAR(device.truePose().position.x(), way, 0.002 * way);
  EXPECT_EQ(device.trueVelocity().x(), 0);
}

TEST(SimulatedDevice, EveryHandRingsAtItsOwnFrequency) {
  for (const Hand& hand : hands()) {
    SimulatedSettings s = bare();
    s.hand = hand;
    s.path = [](double t) { return Configuration{{t > 0 ? 5.0 : 0.0, 0, 0}, {1, 0, 0, 0}}; };
    SimulatedDevice device(s);
    Law law;
    device.start(law, spheretree::test::noSafety(), Clock::Stepped);
    const double mass = s.mass + hand.mass, omega = std::sqrt(hand.stiffness / mass),
                 zeta = hand.damping / 2 / std::sqrt(hand.stiffness * mass);
    ASSERT_LT(zeta, 1) << hand.name;
    device.step();  // in its first millisecond the path jumps: by 5 mm at the end, with the damper pulling
    const double x0 = device.truePose().position.x() - 5, v0 = device.trueVelocity().x();
    const double damped = omega * std::sqrt(1 - zeta * zeta);
    for (int n = 1; n <= 500; ++n) {
      device.step();
      const double t = n * 1e-3;
      const double x =
          5 + std::exp(-zeta * omega * t) * (x0 * std::cos(damped * t) + (v0 + zeta * omega * x0) / damped * std::sin(damped * t));
      ASSERT_NEAR(device.truePose().position.x(), x, 0.02) << hand.name << " at " << t;
    }
  }
}

TEST(SimulatedDevice, FindsHandsByName) {
  ASSERT_TRUE(findHand("arm"));
  EXPECT_EQ(findHand("arm")->mass, 0.554);
  EXPECT_FALSE(findHand("foot"));
  EXPECT_EQ(hands().size(), 6u);
}

TEST(SimulatedDevice, TheWrenchArrivesAfterTheDelay) {
  for (int delay = 0; delay <= 7; ++delay) {
    SimulatedSettings s = bare();
    s.delay = delay;
    SimulatedDevice device(s);
    Law law;
    law.wrench = [](const DeviceState& state) { return Wrench{{state.tick == 3 ? 1.0 : 0.0, 0, 0}, {0, 0, 0}}; };
    device.start(law, spheretree::test::noSafety(), Clock::Stepped);
    for (int n = 0; n < 20; ++n) {
      device.step();
      EXPECT_NEAR(device.actuated().force.x(), n == 3 + delay ? 1 : 0, 0.02) << n;
    }
    EXPECT_NEAR(device.trueVelocity().x(), 1e-3 / s.mass * 1000, 0.1);
  }
}

TEST(SimulatedDevice, EncodersReadWholeSteps) {
  SimulatedSettings s;
  s.path = [](double t) { return Configuration{{10 * std::sin(3 * t), 5 * t, 0}, rotationOf({0.5 * t, 0, 0.2 * t})}; };
  SimulatedDevice device(s);
  Law law;
  run(device, law, 1000);
  std::set<long> counts;
  for (const DeviceState& state : law.seen) {
    const double count = state.handle.position.x() / 0.02;
    ASSERT_NEAR(count, std::round(count), 1e-9);
    counts.insert(std::lround(count));
    const Eigen::Vector3d turn = rotationVector(state.handle.orientation);
    ASSERT_NEAR(turn.z() / 1.4e-4, std::round(turn.z() / 1.4e-4), 1e-6);
  }
  EXPECT_GT(counts.size(), 100u);
}

TEST(SimulatedDevice, SaturatesAndKeepsTheDirection) {
  SimulatedSettings s;
  SimulatedDevice device(s);
  Law law = constantly({{30, 40, 0}, {900, 0, 900}});
  SafetySettings loose = spheretree::test::noSafety();
  device.start(law, loose, Clock::Stepped);
  for (int n = 0; n < 10; ++n) device.step();
  EXPECT_NEAR(device.actuated().force.norm(), 22, 1e-3);
  EXPECT_NEAR(device.actuated().force.x() / device.actuated().force.y(), 0.75, 1e-4);
  EXPECT_LE(device.actuated().torque.cwiseAbs().maxCoeff(), 515);
}

TEST(SimulatedDevice, TheContinuousLoadHeatsToSevenTenths) {
  SimulatedSettings s = bare();
  s.thermal_time = 0.5;
  s.max_force = 22;
  SimulatedDevice device(s);
  Law law = constantly({{3, 0, 0}, {0, 0, 0}});
  run(device, law, 500);
  EXPECT_NEAR(device.motorTemperature().x(), 0.7 * (1 - std::exp(-1)), 0.002);
  EXPECT_NEAR(law.seen.back().temperature, device.motorTemperature().x(), 0.002);
  for (int n = 0; n < 5000; ++n) device.step();
  EXPECT_NEAR(device.motorTemperature().x(), 0.7, 0.002);
  EXPECT_EQ(device.motorTemperature().y(), 0);
}

TEST(SimulatedDevice, TorqueTurnsTheHandle) {
  SimulatedSettings s = bare();
  SimulatedDevice device(s);
  Law law = constantly({{0, 0, 0}, {0, 2, 0}});
  run(device, law, 100);
  const double angle = 0.5 * (2e-3 / s.inertia) * 0.01;  // [rad] after 0.1 s
  EXPECT_LT((rotationVector(device.truePose().orientation) - Eigen::Vector3d(0, angle, 0)).norm(), 2e-3 * angle);
}

TEST(SimulatedDevice, TheHandTurnsItThroughAnyAngle) {
  SimulatedSettings s = bare();
  s.hand = *findHand("fine");
  s.path = [](double t) { return Configuration{{0, 0, 0}, rotationOf({0, 0, 4 * M_PI * t})}; };
  SimulatedDevice device(s);
  Law law;
  run(device, law, 1000);  // 720 degrees
  EXPECT_LT(rotationVector(device.truePose().orientation).norm(), 0.05);
  for (std::size_t n = 1; n < law.seen.size(); ++n)
    ASSERT_LT(displacementBetween(law.seen[n - 1].handle, law.seen[n].handle).rotation.norm(), 0.03) << n;
}

TEST(SimulatedDevice, TheStructureSwingsAtItsMode) {
  for (const double frequency : {30., 80., 150.}) {
    SimulatedSettings s = bare();
    s.mode_frequency = frequency;
    s.mode_damping = 0.01;
    SimulatedDevice device(s);
    Law law;
    law.wrench = [](const DeviceState& state) { return Wrench{{state.tick == 0 ? 5.0 : 0.0, 0, 0}, {0, 0, 0}}; };
    device.start(law, spheretree::test::noSafety(), Clock::Stepped);
    int crossings = 0;
    double last = 0, first_at = 0, last_at = 0;
    for (int n = 0; n < 500; ++n) {
      const double handle = device.truePose().position.x();
      device.step();
      const double apart = handle - law.seen.back().handle.position.x();  // the encoder is on the motor's side
      if (n > 1 && last < 0 && apart >= 0) {
        const double at = n - apart / (apart - last);
        if (crossings++ == 0) first_at = at;
        last_at = at;
      }
      last = apart;
    }
    EXPECT_NEAR((crossings - 1) / (last_at - first_at) * 1000, frequency, 0.01 * frequency);
  }
}

TEST(SimulatedDevice, LetsGoWhenTold) {
  SimulatedSettings s;
  s.release_at = 0.1;
  s.hand = *findHand("firm");
  SimulatedDevice device(s);
  Law law = constantly({{0, 3, 0}, {0, 0, 0}});
  run(device, law, 100);
  const double held = device.truePose().position.y();
  EXPECT_LT(held, 5);  // 1 N/mm, with oscillation
  for (int n = 0; n < 100; ++n) device.step();
  EXPECT_GT(device.truePose().position.y(), held + 20);
}

TEST(SimulatedDevice, JitterAndLostStepsAreTheSameEveryTime) {
  SimulatedSettings s;
  s.jitter = 5e-5;
  s.lost_steps = 0.1;
  s.duration = 2;
  s.path = [](double t) { return Configuration{{10 * std::sin(9 * t), 0, 0}, {1, 0, 0, 0}}; };
  const auto path = [&](std::uint64_t seed) {
    s.seed = seed;
    SimulatedDevice device(s);
    Law law;
    device.start(law, spheretree::test::noSafety(), Clock::Stepped);
    while (device.step()) {
    }
    EXPECT_EQ(device.status().phase, Phase::Ended);
    std::vector<std::uint64_t> bits;
    for (const DeviceState& state : law.seen) bits.push_back(std::bit_cast<std::uint64_t>(state.handle.position.x()));
    return bits;
  };
  const auto one = path(1);
  EXPECT_EQ(one, path(1));
  EXPECT_NE(one, path(2));
  EXPECT_NEAR(static_cast<double>(one.size()), 1800, 60) << "a tenth of the steps is lost";
}

TEST(SimulatedDevice, RefusesSettingsByName) {
  const auto message = [](auto change) -> std::string {
    SimulatedSettings s;
    change(s);
    try {
      SimulatedDevice device(s);
    } catch (const DeviceError& error) {
      EXPECT_EQ(error.fault, DeviceFault::Refused);
      return error.what();
    }
    return "accepted";
  };
  EXPECT_NE(message([](auto& s) { s.mass = 0; }).find("mass is 0"), std::string::npos);
  EXPECT_NE(message([](auto& s) { s.delay = 8; }).find("delay is 8"), std::string::npos);
  EXPECT_NE(message([](auto& s) { s.hand.stiffness = -1; }).find("hand.stiffness"), std::string::npos);
  EXPECT_NE(message([](auto& s) { s.jitter = std::nan(""); }).find("jitter"), std::string::npos);
  EXPECT_NE(message([](auto& s) { s.path = [](double) {
                                    return Configuration{{std::nan(""), 0, 0}, {1, 0, 0, 0}};
                                  }; }).find("path"),
            std::string::npos);
}

/// A linear sampled spring on a damped mass is stable up to K = 2b / (T (1 + 2d)): Colgate and Schenkel's b > KT/2,
/// with d steps of delay.
TEST(SimulatedDevice, TheSampledSpringBecomesUnstableAtItsLimit) {
  for (const double damping : {1.0, 3.0})
    for (int delay = 0; delay <= 2; ++delay) {
      const double limit = 2 * damping / (1e-3 * (1 + 2 * delay)) / 1000;  // [N/mm]
      const auto grows = [&](double stiffness) {
        SimulatedSettings s = bare();
        s.viscous = damping;
        s.max_force = 1000;
        s.mass = 1;  // slow compared with a millisecond, as the formula assumes
        s.delay = delay;
        SimulatedDevice device(s);
        Law law;
        law.wrench = [stiffness](const DeviceState& state) {
          return Wrench{{state.tick < 5 ? 50.0 : -stiffness * state.handle.position.x(), 0, 0}, {0, 0, 0}};
        };
        run(device, law, 4000);
        double early = 0, late = 0;
        for (std::size_t n = 0; n < 1000; ++n) {
          early = std::max(early, std::abs(law.seen[n + 500].handle.position.x()));
          late = std::max(late, std::abs(law.seen[n + 3000].handle.position.x()));
        }
        return late > early;
      };
      EXPECT_FALSE(grows(0.95 * limit)) << damping << ' ' << delay;
      EXPECT_TRUE(grows(1.05 * limit)) << damping << ' ' << delay;
    }
}

/// The largest stiffness, in steps of 12 %, up to which a wall stays quiet: ring <= 0.1 N peak to peak and <= 20 mN
/// above 30 Hz, while the hand holds still after a tap at 300 mm/s and a push of 8 N.
double quietStiffness(const SimulatedSettings& settings, double from) {
  double quiet = 0;
  for (double stiffness = from; stiffness < 100; stiffness *= 1.12) {  // [N/mm]
    const spheretree::test::Press felt = spheretree::test::press(settings, stiffness, false, 8, 300, 0.45);
    if (felt.ring > 0.1 || felt.rough > 0.02) break;
    quiet = stiffness;
  }
  return quiet;
}

TEST(SimulatedDevice, WallsBecomeRestlessWhereTheTableSays) {
  struct Row {
    const char* hand;
    double stated[3];  // [N/mm], for a delay of 0, 1, 2 steps
  };
  for (const Row& row :
       {Row{"light", {10.5, 3.0, 1.7}}, Row{"fine", {13.2, 3.8, 2.15}}, Row{"arm", {14.8, 4.25, 3.0}}, Row{"firm", {11.8, 3.8, 1.9}}})
    for (int delay = 0; delay < 3; ++delay) {
      SimulatedSettings s;
      s.hand = *findHand(row.hand);
      s.delay = delay;
      const double quiet = quietStiffness(s, 0.1 * std::pow(1.12, 20));
      std::printf("quiet up to %-5s d=%d: %6.2f N/mm, stated %6.2f\n", row.hand, delay, quiet, row.stated[delay]);
      EXPECT_NEAR(quiet / row.stated[delay], 1, 0.15) << row.hand << ", delay " << delay;
    }
}

TEST(SimulatedDevice, WithoutCoulombFrictionThePapersStiffnessIsNotQuiet) {
  for (const char* hand : {"light", "fine", "arm"})
    for (int delay = 0; delay < 3; ++delay) {
      SimulatedSettings s;
      s.hand = *findHand(hand);
      s.delay = delay;
      s.coulomb = 0;
      EXPECT_LT(quietStiffness(s, 0.1), 0.7) << hand << ' ' << delay;
      s.coulomb = 0.2;
      EXPECT_GE(quietStiffness(s, 1), 1) << hand << ' ' << delay;
    }
}

/// About an axis, with inertia 1e-4 kg m^2 and the hand of the table: ring <= 10 N mm after a push of 10 N mm.
TEST(SimulatedDevice, AngularWallsBecomeRestlessWhereTheTableSays) {
  const double stated[2][3] = {{16, 4.7, 3.0}, {3.3, 1.1, 0.7}};  // [N m/rad]; with and without Coulomb friction
  for (int without = 0; without < 2; ++without)
    for (int delay = 0; delay < 3; ++delay) {
      SimulatedSettings s;
      s.delay = delay;
      if (without) s.coulomb_rotation = 0;
      double quiet = 0;
      for (double stiffness = 100; stiffness < 1e5; stiffness *= 1.12) {
        const spheretree::test::Press felt = spheretree::test::press(s, stiffness, true, 10, 3, 0.6);
        if (felt.ring > 10 || felt.rough > 2) break;
        quiet = stiffness / 1000;
      }
      std::printf("quiet up to d=%d %s Coulomb friction: %6.2f N m/rad, stated %5.2f\n", delay, without ? "without" : "with", quiet,
                  stated[without][delay]);
      EXPECT_NEAR(quiet / stated[without][delay], 1, without ? 0.15 : 0.3) << "delay " << delay;
    }
}

/// A sampled spring gives away W = sum over the contact of (T/2 + dT) v K v T, and no more: within 8 %.
TEST(SimulatedDevice, TheSampledSpringLeaksWhatTheFormulaSays) {
  int judged = 0;
  for (int delay = 0; delay < 2; ++delay)
    for (const char* hand : {"arm", "fine", "light", "firm"})
      for (const double viscous : {0.005, 0.1, 1.0})
        for (const double stiffness : {1.0, 2.0, 4.0}) {
          SimulatedSettings s;
          s.hand = *findHand(hand);
          s.delay = delay;
          s.viscous = viscous;
          s.position_step = 0;
          const double depth = std::min(5000 / s.hand.stiffness, 20.0);  // down at 100 mm/s, hold until 0.6 s, up again
          s.path = [=](double t) {
            return Configuration{{0, 0, t < 0.6 ? std::max(5 - 100 * t, -depth) : std::min(-depth + 100 * (t - 0.6), 10.0)}, {1, 0, 0, 0}};
          };
          SimulatedDevice device(s);
          spheretree::test::Wall wall;
          wall.stiffness = stiffness;
          device.start(wall, spheretree::test::noSafety(), Clock::Stepped);
          double lowest = 0, leak = 0;
          for (int n = 0; n < 1600; ++n) {
            const double before = device.truePose().position.z();
            device.step();
            const double way = device.truePose().position.z() - before;  // v T
            if (before < 0 || device.actuated().force.z() > 0) leak += (0.5 + delay) * stiffness * way * way;
            lowest = std::min(lowest, device.energy());
          }
          ASSERT_GT(leak, 0.05) << hand << ": no contact to speak of";
          EXPECT_NEAR(-lowest / leak, 1, 0.08) << hand << ", delay " << delay << ", b " << viscous << ", K " << stiffness;
          ++judged;
        }
  EXPECT_EQ(judged, 72);
}

}  // namespace
}  // namespace spheretree::device
