// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/passivity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <vector>

#include "press.h"

namespace spheretree::device {
namespace {

using Eigen::Vector3d;

/// A given motion, and the force that a renderer intends at each place: the energy that the hand puts into the sent
/// wrench.
struct Driven {
  double energy = 0, lowest = 0, leak = 0, stored = 0;  // [mJ]; the last two of a spring of 1 N/mm, 1000 N mm/rad
  int actions = 0;
};

Driven drive(int delay, bool is_controlled, bool is_turn, const std::function<double(double, double)>& force) {
  PassivityControl control(delay, 0.01);
  std::vector<Wrench> sent(static_cast<std::size_t>(delay) + 1);
  Driven run;
  double last = 0;
  for (int n = 0; n < 4000; ++n) {
    const double x = std::sin(0.02 * n) + 0.2 * std::sin(0.053 * n), way = n > 0 ? x - last : 0, f = force(x, way);
    const Configuration pose = is_turn ? Configuration{{0, 0, 0}, rotationOf({0, 0.01 * x, 0})} : Configuration{{0, 0, x}, {1, 0, 0, 0}};
    const Wrench& held = sent[sent.size() - 1 - static_cast<std::size_t>(delay)];
    run.energy -= is_turn ? 0.01 * held.torque.y() * way : held.force.z() * way;
    run.lowest = std::min(run.lowest, run.energy);
    run.leak += (0.5 + delay) * (is_turn ? 0.1 : 1) * way * way;
    last = x;
    run.stored = (is_turn ? 0.05 : 0.5) * x * x;
    const Wrench meant = is_turn ? Wrench{{0, 0, 0}, {0, 10 * f, 0}} : Wrench{{0, 0, f}, {0, 0, 0}};
    sent.push_back(is_controlled ? control.control(pose, meant) : meant);
    if (is_controlled) control.sent(sent.back());
    run.actions += is_controlled && !control.added().force.isZero(0);
    run.actions += is_controlled && !control.added().torque.isZero(0);
  }
  return run;
}

TEST(PassivityControl, RemovesTheEnergyOfHoldAndDelay) {
  const auto spring = [](double x, double) { return -x; };
  for (const bool is_turn : {false, true})
    for (const int delay : {0, 1, 3}) {
      const Driven bare = drive(delay, false, is_turn, spring), controlled = drive(delay, true, is_turn, spring);
      EXPECT_NEAR(bare.energy, bare.stored - bare.leak, 0.02 * bare.leak) << "the closed form";
      EXPECT_GT(bare.leak, is_turn ? 0.03 : 0.3);
      EXPECT_GT(controlled.lowest, -0.05 * bare.leak) << delay;
      EXPECT_GT(controlled.actions, 1000);
    }
}

// A spring that pushes back harder on the way out than on the way in.
TEST(PassivityControl, RemovesTheEnergyOfARenderer) {
  const auto active = [](double x, double way) { return x * way < 0 ? -1.3 * x : -x; };
  EXPECT_LT(drive(0, false, false, active).energy, -3);
  EXPECT_GT(drive(0, true, false, active).lowest, -0.3 * 0.5 * 1.2 * 1.2);  // of one way out
}

TEST(PassivityControl, KeepsAPassiveWrenchBitForBit) {
  PassivityControl control(1, 0.01);
  for (int n = 0; n < 1000; ++n) {  // a weight that the hand lifts and lowers
    const Wrench weight{{0, 0.1, -0.7}, {3, 0, 0}};
    const Wrench sent = control.control({{0, 0, 0.25 * (n % 100)}, {1, 0, 0, 0}}, weight);
    control.sent(sent);
    if (n < 101) continue;  // it is absent before
    ASSERT_EQ(sent.force, weight.force);
    ASSERT_EQ(sent.torque, weight.torque);
  }
  // In free space nothing is sent, even with a debt.
  for (int n = 0; n < 100; ++n) {
    ASSERT_TRUE(control.control({{0, 0.1 * n, 0}, {1, 0, 0, 0}}, {}).force.isZero(0));
    control.sent({});
  }
}

// Motors that cannot produce the requested force leave the rest of the debt.
TEST(PassivityControl, CountsWhatTheMotorsGet) {
  double debt[2];
  for (const bool is_limited : {false, true}) {
    PassivityControl control(0, 1);
    double given = 0;               // to the hand [mJ]
    for (int n = 0; n < 40; ++n) {  // pushed along its way, then hardly at all
      const Wrench meant{{0, 0, n < 20 ? 1 : 1e-9}, {0, 0, 0}};
      Wrench out = control.control({{0, 0, 0.1 * n}, {1, 0, 0, 0}}, meant);
      ASSERT_NEAR(control.debt(), given, 1e-12);
      if (is_limited) out.force.z() = std::max(out.force.z(), n < 20 ? 0.9 : -0.02);
      control.sent(out);
      EXPECT_EQ(control.added().force, out.force - meant.force);
      given += 0.1 * out.force.z();
    }
    debt[is_limited] = control.debt();
  }
  EXPECT_LT(debt[0], 1e-6);
  EXPECT_GT(debt[1], 1);
}

struct LoggedWall final : Renderer {
  spheretree::test::Wall wall;
  int actions = 0;
  Rendered render(const DeviceState& state) noexcept override {
    actions += !state.added.force.isZero(0);
    return wall.render(state);
  }
};

struct Ring {
  double swing = 0, lowest_energy = 0;
  std::uint32_t events = 0;
};

Ring tap(const char* hand, int delay, double stiffness, bool is_controlled) {
  SimulatedSettings s;
  s.hand = *findHand(hand);
  s.delay = delay;
  s.coulomb = s.coulomb_rotation = 0;
  s.max_force = 100;
  const double depth = 8000 / s.hand.stiffness, stop = (1 + depth) / 300;
  s.path = [=](double t) { return Configuration{{0, 0, std::max(1 - 300 * t, -depth)}, {1, 0, 0, 0}}; };
  SimulatedDevice device(s);
  LoggedWall wall;
  wall.wall.stiffness = stiffness;
  SafetySettings safety = spheretree::test::noSafety();
  safety.passivity_control = is_controlled;
  device.start(wall, safety, Clock::Stepped);
  Ring ring;
  double low = 1e9, high = -1e9;
  int actions = 0;
  for (int n = 0; n < 1000 * stop + 2500; ++n) {
    device.step();
    actions += (device.status().safety & kPassivityControl) != 0;
    ring.lowest_energy = std::min(ring.lowest_energy, device.energy());
    if (n < 1000 * stop + 1000) continue;
    low = std::min(low, device.actuated().force.z());
    high = std::max(high, device.actuated().force.z());
  }
  EXPECT_LE(std::abs(actions - wall.actions), 1) << "the renderer knows of each action a step later";
  ring.swing = high - low;
  ring.events = device.status().safety_so_far;
  return ring;
}

// Without Coulomb friction, no wall of 2 N/mm is quiet one step late unless it is controlled.
TEST(PassivityControl, QuietensAWallThatIsTooStiffForItsDelay) {
  for (const char* hand : {"light", "fine", "arm", "firm"}) {
    const Ring quiet = tap(hand, 1, 2, true);
    EXPECT_LT(quiet.swing, 0.1) << hand;
    EXPECT_GT(quiet.lowest_energy, -0.05) << hand;
    EXPECT_TRUE(quiet.events & kPassivityControl);
  }
  const Ring loud = tap("light", 1, 2, false);
  EXPECT_GT(loud.swing, 10);
  EXPECT_LT(loud.lowest_energy, -100);
  EXPECT_FALSE(loud.events & kPassivityControl);
}

// The table of docs/device.md: a controlled wall swings less and gives less energy, whatever hand taps it.
TEST(PassivityControl, TakesSwingAndEnergyFromEveryWallOfTheTable) {
  struct Row {
    double stiffness;  // [N/mm]
    int delay;         // [steps]
    const char* hand;
  };
  for (const Row& row : {Row{1, 2, "light"}, Row{2, 1, "light"}, Row{2, 1, "fine"}, Row{2, 1, "arm"}, Row{2, 1, "teleoperator"},
                         Row{4, 1, "light"}, Row{4, 2, "light"}}) {
    const Ring off = tap(row.hand, row.delay, row.stiffness, false), on = tap(row.hand, row.delay, row.stiffness, true);
    std::printf("wall of %g N/mm, %d late, %-12s off: %6.2f N %10.3f mJ, on: %6.2f N %10.3f mJ\n", row.stiffness, row.delay, row.hand,
                off.swing, off.lowest_energy, on.swing, on.lowest_energy);
    EXPECT_LT(on.swing, off.swing) << row.hand;
    EXPECT_GE(on.lowest_energy, off.lowest_energy) << row.hand;
  }
}

TEST(PassivityControl, SettingsOutOfRangeAreRefused) {
  SafetySettings s;
  s.passivity_damping = 0;
  EXPECT_NE(findFault(s).find("passivity_damping"), std::string::npos);
  s = {};
  s.delay = kMaxDelay + 1;
  EXPECT_NE(findFault(s).find("delay"), std::string::npos);
}

}  // namespace
}  // namespace spheretree::device
