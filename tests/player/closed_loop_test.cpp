// SPDX-License-Identifier: GPL-3.0-or-later
// The measures of the closed loop against closed forms, and faults inserted into the loop: each must be detected.
#include "scenarios/closed_loop.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/shape_trees.h"

namespace spheretree::player {
namespace {

std::vector<double> sine(double amplitude, double hertz, int steps, double noise = 0) {
  test::Random random(1);
  std::vector<double> out;
  for (int n = 0; n < steps; ++n)
    out.push_back(3 + amplitude * std::sin(2 * std::numbers::pi * hertz * n / 1000) + noise * random.between(-1, 1));
  return out;
}

TEST(Roughness, OfSinesAndNoiseIsTheClosedForm) {
  for (const double hertz : {40.0, 123.0, 400.0}) {
    const Spectrum s = roughness(sine(0.2, hertz, 4000));
    EXPECT_NEAR(s.rms, 0.2 / std::sqrt(2.0), 2e-3) << hertz;
    EXPECT_NEAR(s.largest_line, 0.2, 1e-3) << hertz;
  }
  EXPECT_LT(roughness(sine(1, 10, 4000)).rms, 1e-3) << "a hand's own motion does not count";
  EXPECT_EQ(roughness(sine(1, 100, 999)).rms, 0) << "less than a window";
  // White noise of +-1 has rms 1 / sqrt 3, of which 30 to 500 Hz is 94 %.
  EXPECT_NEAR(roughness(sine(0, 100, 60'000, 1)).rms, std::sqrt(0.94 / 3), 0.01);
}

/// A ball on a ball, pressed at the pole: equivalent to a plane, and fast.
struct Loop {
  Body ball, ground;
  builder::Progress progress;
  BodyLibrary bodies{builder::Quality::Quick, runtime::ContactSurface::Leaves, progress};
  ScenarioContext context{bodies, {}, progress};

  static Body body(double radius) {
    TriangleMesh mesh = box({-1, -1, -1}, {1, 1, 1});
    builder::DistanceField field(mesh);
    return {"ball", std::move(mesh), test::oneBallTree(static_cast<float>(radius)), std::move(field)};
  }
  Loop() : ball(body(5)), ground(body(200)) {}
  ClosedLoop run(double stiffness, int delay, Friction friction, int steps = 3000) {
    ScenarioRun::Options options;
    options.coupling = {stiffness, 1000 * stiffness};
    ScenarioRun trial(ball, {{&ground, {{0, 0, -200}, kUpright}}}, Mode::Constrained, options);
    const auto path = [](double t) {
      return Configuration{{0, 0, 9 - std::min(100 * t, 12.0) + std::clamp(100 * (t - 2), 0.0, 12.0)}, kUpright};
    };
    return runHand(context, trial, handAt("fine", delay, friction, path), steps);
  }
};

TEST(ClosedLoop, AQuietWallIsQuietAndGivesTheLeakOnly) {
  Loop loop;
  for (const Friction friction : {Friction::On, Friction::Off}) {
    const ClosedLoop quiet = loop.run(1, 0, friction);
    EXPECT_LT(quiet.energyBeyond(1.15), 0.02);
    EXPECT_GT(quiet.leak, 0.01);
    EXPECT_LT(roughness(quiet.force(2, 1000, 2000)).rms, 0.02);
    EXPECT_GT(quiet.force(2, 1900, 1901)[0], 1) << "it pressed";
  }
}

TEST(ClosedLoop, AWallThatIsTooStiffOrTooLateShowsAsARing) {
  Loop loop;
  EXPECT_GT(roughness(loop.run(8, 2, Friction::On).force(2, 1000, 2000)).rms, 0.1);
  EXPECT_GT(roughness(loop.run(4, 2, Friction::Off).force(2, 1000, 2000)).rms, 0.1);
}

TEST(ClosedLoop, EnergyThatARendererAddsShows) {
  Loop loop;
  ClosedLoop honest = loop.run(1, 0, Friction::Off);
  // The leak of a loop that is 2 ms late is five times as large: with the leak of a loop without delay, it must not
  // pass.
  ClosedLoop late = loop.run(1, 2, Friction::Off);
  late.leak /= 5;
  EXPECT_LT(honest.energyBeyond(1.15), 0.02);
  EXPECT_GT(late.energyBeyond(1.15), 0.02);
}

TEST(ClosedLoop, CtrlCEndsIt) {
  Loop loop;
  loop.progress.cancel();
  EXPECT_THROW(loop.run(1, 0, Friction::On), builder::Cancelled);
}

}  // namespace
}  // namespace spheretree::player
