// SPDX-License-Identifier: Apache-2.0
// Every constant of the device layer is one in time: the same second passes at each rate of the servo loop.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "press.h"
#include "spheretree/device/safety.h"
#include "spheretree/device/simulated_device.h"

namespace spheretree::device {
namespace {

const double kRates[] = {500, 1000, 2000, 4000, 8000};  // [Hz]

SafetySettings at(double rate, SafetySettings settings = {}) {
  settings.period = 1 / rate;
  return settings;
}

/// What happens at a time [s].
using Story = std::function<void(double time, DeviceState& state, Rendered& rendered)>;

/// The time at which `ended` first holds, while a story is told at `rate`; NaN if never within 5 s.
double timeUntil(double rate, const SafetySettings& settings, const Story& story, std::function<bool(const Wrench&)> ended) {
  Safety safety(at(rate, settings));
  DeviceState state;
  for (int n = 0; n < 5 * rate; ++n) {
    state.time = n / rate;
    Rendered rendered;
    story(state.time, state, rendered);
    if (ended(safety.limit(state, rendered))) return state.time;
  }
  return std::nan("");
}

struct Rule {
  const char* name;
  SafetySettings settings;
  Story story;
  std::function<bool(const Wrench&)> ended;
  double expected;  // [s]
};

std::function<bool(const Wrench&)> reaches(double force) {
  return [=](const Wrench& w) { return w.force.norm() >= force * (1 - 1e-9); };
}

/// Holds once the force has been at least `pressed` and is below `force`.
std::function<bool(const Wrench&)> falls(double pressed, double force) {
  return [=, was_pressed = false](const Wrench& w) mutable {
    was_pressed = was_pressed || w.force.norm() >= pressed;
    return was_pressed && w.force.norm() < force;
  };
}

TEST(Rate, EachRuleTakesTheSameTimeAtEachRate) {
  SafetySettings open;
  open.start_guard = false;
  SafetySettings no_impact = open;
  no_impact.contact_start = 0;
  const Story push = [](double, DeviceState&, Rendered& r) { r.wrench.force = {6, 0, 0}; };
  const Rule rules[] = {
      {"slew", no_impact, push, reaches(6), 0.012},
      {"ramp after the guard",
       {},
       [](double t, DeviceState&, Rendered& r) {
         r.wrench.force = {t > 0.1 ? 4.0 : 0, 0, 0};
       },
       reaches(2),
       1.003},
      {"guard",
       {},
       [](double t, DeviceState&, Rendered& r) {
         r.wrench.force = {t < 1 || t > 1.0031 ? 2.0 : 0, 0, 0};
       },
       reaches(1e-9),
       1.0035},
      {"stale contacts fade", open,
       [](double t, DeviceState&, Rendered& r) {
         r.wrench.force = {4, 0, 0}, r.model_age = std::max(0.0, t - 1);
       },
       falls(3, 2), 1.07},
      {"stale poses fade", open,
       [](double t, DeviceState& s, Rendered& r) {
         r.wrench.force = {4, 0, 0}, s.age = std::max(0.0, t - 1);
       },
       falls(3, 2), 1.07},
      {"a failed renderer fades", open,
       [](double t, DeviceState&, Rendered& r) {
         r.wrench.force = {4, 0, 0}, r.failed = t > 1;
       },
       falls(3, 2), 1.055},
      {"fast and strong fades", open,
       [](double t, DeviceState& s, Rendered& r) {
         r.wrench.force = {4, 0, 0}, s.handle.position.x() = 2000 * std::max(0.0, t - 1);
       },
       falls(3, 2), 1.025},
      {"warm motors", open,
       [](double t, DeviceState& s, Rendered& r) {
         r.wrench.force = {8, 0, 0}, s.temperature = t > 1 ? 0.8 : 0;
       },
       falls(7, 4), 1 + std::log(2.0)},
  };
  for (const Rule& rule : rules)
    for (const double rate : kRates) {
      const double time = timeUntil(rate, rule.settings, rule.story, rule.ended);
      EXPECT_NEAR(time, rule.expected, 3 / rate + 0.002) << rule.name << " at " << rate << " Hz";
    }
}

TEST(Rate, AContactMayBeginFastForTheSameTime) {
  SafetySettings settings;
  settings.start_guard = false;
  for (const double rate : kRates) {
    Safety safety(at(rate, settings));
    DeviceState state;
    double fast_until = 0;  // a force that alternates is limited once the contact has begun
    for (int n = 0; n < 0.12 * rate; ++n) {
      state.time = n / rate;
      const double asked = state.time < 0.02 ? 0
                           : n % 2           ? 7
                                             : 1,
                   sent = safety.limit(state, {{{asked, 0, 0}, {0, 0, 0}}, 0, false}).force.norm();
      if (sent == 7) fast_until = state.time;
    }
    EXPECT_NEAR(fast_until, 0.03, 2.5 / rate) << rate;
  }
}

TEST(Rate, SettingsOutOfRangeAreRefused) {
  EXPECT_EQ(findFault(at(8000)), "");
  EXPECT_EQ(findFault(at(500)), "");
  EXPECT_NE(findFault(at(9000)).find("period"), std::string::npos);
  EXPECT_NE(findFault(at(400)).find("period"), std::string::npos);
}

/// A mass under a constant force, with viscous friction: v = F/b (1 - exp(-b t/m)).
TEST(Rate, TheSimulatedDeviceMovesAlikeAtEachRate) {
  struct Pull final : Renderer {
    Rendered render(const DeviceState&) noexcept override { return {{{0.5, 0, 0}, {0, 0, 0}}, 0, false}; }
  } pull;
  for (const double rate : kRates) {
    SimulatedSettings s;
    s.hand = {"none", 0, 0, 0, 0, 0, 0};
    s.coulomb = s.coulomb_rotation = s.position_step = 0;
    s.viscous = 1;
    s.mass = 0.2;
    s.duration = 0.3;
    SimulatedDevice device(s);
    device.start(pull, at(rate, spheretree::test::noSafety()), Clock::Stepped);
    while (device.step()) {
    }
    EXPECT_NEAR(device.trueVelocity().x(), 500 * (1 - std::exp(-0.3 / 0.2)), 0.3) << rate << " Hz; a command has 16 bits";
    EXPECT_EQ(device.status().ticks, static_cast<std::uint64_t>(std::lround(0.3 * rate)));
  }
}

/// The limit of Colgate and Schenkel, K = 2b / (T (1 + 2d)), moves with the rate.
TEST(Rate, TheStiffestStableWallGrowsWithTheRate) {
  struct Spring final : Renderer {
    double stiffness = 0, early = 0, late = 0;
    Rendered render(const DeviceState& state) noexcept override {
      const double x = state.handle.position.x();
      if (state.time > 0.5 && state.time < 1.5) early = std::max(early, std::abs(x));
      if (state.time > 3) late = std::max(late, std::abs(x));
      return {{{state.time < 0.005 ? 50.0 : -stiffness * x, 0, 0}, {0, 0, 0}}, 0, false};
    }
  };
  for (const double rate : kRates)
    for (const int delay : {0, 1}) {
      const double limit = 2 * 1.0 * rate / (1 + 2 * delay) / 1000;  // [N/mm]
      const auto grows = [&](double stiffness) {
        SimulatedSettings s;
        s.hand = {"none", 0, 0, 0, 0, 0, 0};
        s.coulomb = s.coulomb_rotation = s.position_step = 0;
        s.viscous = 1;
        s.max_force = s.continuous_force = 1000;
        s.mass = 1000 / rate;  // slow compared with a step, as the formula assumes
        s.delay = delay;
        s.duration = 4;
        SimulatedDevice device(s);
        Spring spring;
        spring.stiffness = stiffness;
        device.start(spring, at(rate, spheretree::test::noSafety()), Clock::Stepped);
        while (device.step()) {
        }
        return spring.late > spring.early;
      };
      EXPECT_FALSE(grows(0.95 * limit)) << rate << " Hz, " << delay;
      EXPECT_TRUE(grows(1.05 * limit)) << rate << " Hz, " << delay;
    }
}

/// A hand presses on a wall of 2 N/mm that is a step late: the swing that passivity control leaves, and the energy.
TEST(Rate, PassivityControlQuietsAWallAtEachRate) {
  for (const double rate : kRates) {
    SimulatedSettings s;
    s.hand = *findHand("light");
    s.coulomb = s.coulomb_rotation = 0;
    s.delay = 1;
    s.path = [](double t) { return Configuration{{0, 0, std::max(1 - 300 * t, -80.0)}, {1, 0, 0, 0}}; };
    s.duration = 2.5;
    s.max_force = 100;
    const auto swing = [&](bool controlled) {
      SimulatedDevice device(s);
      spheretree::test::Wall wall;
      wall.stiffness = 2 * rate / 1000;  // as unstable as at 1 kHz
      SafetySettings safety = at(rate, spheretree::test::noSafety());
      safety.passivity_control = controlled;
      device.start(wall, safety, Clock::Stepped);
      while (device.step()) {
      }
      const auto first = wall.answer.end() - static_cast<std::ptrdiff_t>(rate);
      const auto [low, high] = std::minmax_element(first, wall.answer.end());
      return *high - *low;
    };
    const double off = swing(false), on = swing(true);
    EXPECT_LT(on, 0.2 * off) << rate << " Hz: " << off << " N without, " << on << " N with";
  }
}

}  // namespace
}  // namespace spheretree::device
