// SPDX-License-Identifier: Apache-2.0
// Nothing is passed through: plates and a wire, at many speeds and angles, 10^3 runs; SPHERETREE_LONG=1: 10^4 (about 3 minutes).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>

#include "spheretree/runtime/step.h"
#include "support/shape_trees.h"

namespace spheretree::runtime {
namespace {

using test::Random;

int runCount() { return std::getenv("SPHERETREE_LONG") ? 10000 : 300; }

struct Rig {
  Scene scene;
  std::unique_ptr<Workspace> workspace;

  Rig(SphereTree tool, SphereTree object) {
    SceneDescription d;
    d.tool = std::move(tool);
    d.objects.push_back({std::move(object), {}});
    std::string fault;
    EXPECT_TRUE(compileScene(d, scene, fault)) << fault;
    workspace = std::make_unique<Workspace>(scene);
  }
};

struct Way {
  Eigen::Vector3d target, direction;
  Quaternion orientation;
  double before, after, step;  // [mm] along the way; a step above 40: one jump
};

/// True if the reference point of the graphic tool stays above z = 0 and its leaves out of those of the object.
bool staysAbove(Rig& rig, const Way& way, Mode mode = Mode::Constrained) {
  reset(*rig.workspace);
  for (double s = -way.before; s <= way.after; s += way.step) {
    const StepResult r = step(rig.scene, {way.target + way.direction * s, way.orientation}, mode, *rig.workspace);
    if (!(r.graphic.position.z() > 0) || r.penetration > kGapTolerance) return false;
  }
  return true;
}

/// `tilt` from straight down [rad].
Eigen::Vector3d downwards(double tilt, double heading) {
  return {std::sin(tilt) * std::cos(heading), std::sin(tilt) * std::sin(heading), -std::cos(tilt)};
}

constexpr std::array kSpeeds{0.05, 0.5, 1.0, 2.0, 50.0};  // [mm] a step: 0.05 to 2 m/s, and one jump

Way wayOntoPlate(Random& random, int run) {
  const double tilt = random.between(0, 80) * M_PI / 180, speed = kSpeeds[static_cast<std::size_t>(run) % kSpeeds.size()];
  Way way;
  way.target = {random.between(-3, 3), random.between(-3, 3), 0};
  way.direction = downwards(tilt, random.between(0, 6.28));
  way.orientation = {1, 0, 0, 0};
  way.before = 7 / std::cos(tilt);
  way.after = std::min(30.0, 13 / std::max(std::sin(tilt), 1e-3));  // the path stays over the plate
  if (speed > 40) way.before = std::max(way.before, speed - way.after);
  way.step = speed;
  return way;
}

TEST(Crossing, NoneOfPlates) {
  // 40 x 40 mm of balls as thick as the plate.
  constexpr std::array kThickness{2.0, 1.0, 0.5, 0.2};
  int crossings = 0;
  for (std::size_t t = 0; t < kThickness.size(); ++t) {
    const SphereTree plate = test::boxTree({20, 20, 0}, {64, 64, 1}, kThickness[t] / 2);
    Rig ball(test::oneBallTree(5), plate), probe(test::rodTree(30, 40, 1), plate);
    Random random(t + 1);
    for (int run = 0; run < runCount() / 5; ++run) crossings += !staysAbove(run / 5 % 2 ? ball : probe, wayOntoPlate(random, run));
  }
  EXPECT_EQ(crossings, 0);
  RecordProperty("runs", 4 * (runCount() / 5));
}

TEST(Crossing, NoneOfAWire) {
  // A cube of 20 mm onto a wire 0.5 mm thick: too wide to slip off.
  Rig rig(test::boxTree({9, 9, 9}, {8, 8, 8}, 1.4), test::boxTree({0, 30, 0}, {1, 256, 1}, 0.25));
  Random random(5);
  int crossings = 0;
  for (int run = 0; run < runCount() / 5; ++run) {
    Way way{{random.between(-2, 2), random.between(-2, 2), 0},
            downwards(random.between(0, 0.15), random.between(0, 6.28)),
            {1, 0, 0, 0},
            16,
            30,
            kSpeeds[static_cast<std::size_t>(run) % kSpeeds.size()]};
    if (way.step > 40) way.before = 20;
    crossings += !staysAbove(rig, way);
  }
  EXPECT_EQ(crossings, 0);
  RecordProperty("runs", runCount() / 5);
}

TEST(Crossing, ThePaperPassesThrough) {  // the runs would show it
  Rig rig(test::oneBallTree(5), test::boxTree({20, 20, 0}, {64, 64, 1}, 0.1));
  Random random(1);
  int crossings = 0;
  for (int run = 0; run < 10; ++run) crossings += !staysAbove(rig, wayOntoPlate(random, run), Mode::Paper);
  EXPECT_GE(crossings, 9);
}

}  // namespace
}  // namespace spheretree::runtime
