// SPDX-License-Identifier: GPL-3.0-or-later
#include "run/measure_device.h"

#include <gtest/gtest.h>

#include <cmath>

#include "spheretree/device/simulated_device.h"

namespace spheretree::player {
namespace {

struct Measured {
  explicit Measured(double rate) : probe(1 / rate) {}
  DeviceProbe probe;
  double strongest = 0, fastest = 0;  // of the true motion [N, mm/s]
};

/// Measures a free handle of a known device.
void measure(const device::SimulatedSettings& settings, double rate, Measured& out) {
  device::SimulatedDevice device(settings);
  device::SafetySettings safety;
  safety.period = 1 / rate;
  safety.max_force = 1;
  device.start(out.probe, safety, device::Clock::Stepped);
  for (long n = 0; n < std::lround(200 * rate) && !out.probe.isDone() && device.step(); ++n) {
    out.strongest = std::max(out.strongest, device.actuated().force.norm());
    out.fastest = std::max(out.fastest, device.trueVelocity().norm());
  }
  EXPECT_TRUE(out.probe.isDone());
}

device::SimulatedSettings freeHandle() {
  device::SimulatedSettings settings;
  settings.hand = *device::findHand("released");
  return settings;
}

TEST(MeasureDevice, FindsWhatTheSimulatedDeviceIs) {
  for (const double rate : {1000.0, 4000.0})
    for (const int delay : {0, 1, 3}) {
      device::SimulatedSettings settings = freeHandle();
      settings.delay = delay;
      settings.position_step = 0.015;
      Measured m(rate);
      measure(settings, rate, m);
      ASSERT_TRUE(m.probe.count());
      EXPECT_NEAR(*m.probe.count(), 0.015, 1e-9);
      ASSERT_TRUE(m.probe.latency());
      EXPECT_NEAR(1e3 * *m.probe.latency(), 1e3 * delay / rate, std::max(0.08, 0.05 * 1e3 * delay / rate)) << rate << " Hz, " << delay;
      for (const std::optional<double>& friction : m.probe.friction()) {
        ASSERT_TRUE(friction);
        EXPECT_NEAR(*friction, 0.2, 0.005);
      }
      EXPECT_NEAR(m.probe.meanPeriod(), 1 / rate, 1e-9);
      EXPECT_LT(m.probe.jitter(1), 1e-9);
      EXPECT_LE(m.strongest, 1.001);
      EXPECT_LT(m.fastest, 20);
    }
}

/// Other masses, more and less friction, and a coarse encoder: gentle with all of them.
TEST(MeasureDevice, NeverStrongNorFast) {
  for (const double mass : {0.05, 0.5})
    for (const double friction : {0.05, 0.6})
      for (const double count : {0.0, 0.06}) {
        device::SimulatedSettings settings = freeHandle();
        settings.mass = mass;
        settings.coulomb = friction;
        settings.position_step = count;
        settings.delay = 1;
        Measured m(1000);
        measure(settings, 1000, m);
        EXPECT_LE(m.strongest, 1.001) << mass << ' ' << friction << ' ' << count;
        EXPECT_LT(m.fastest, 20) << mass << ' ' << friction << ' ' << count;
        ASSERT_TRUE(m.probe.friction()[1]);
        EXPECT_NEAR(*m.probe.friction()[1], friction, 0.1 * friction + 0.01);
        EXPECT_EQ(m.probe.count().has_value(), count > 0) << "an encoder without counts";
      }
}

TEST(MeasureDevice, AHandleThatIsHeldOrDriftsIsSaidSo) {
  device::SimulatedSettings held = freeHandle();
  held.coulomb = 5;
  Measured stuck(1000);
  measure(held, 1000, stuck);
  EXPECT_FALSE(stuck.probe.latency());
  EXPECT_FALSE(stuck.probe.friction()[0]);
  device::SimulatedSettings pulled = freeHandle();
  pulled.hand = *device::findHand("arm");
  pulled.path = [](double t) { return Configuration{{0, -10 * t, 0}, {1, 0, 0, 0}}; };
  Measured drifting(1000);
  measure(pulled, 1000, drifting);
  EXPECT_TRUE(drifting.probe.hasDrifted());
}

}  // namespace
}  // namespace spheretree::player
