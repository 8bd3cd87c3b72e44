// SPDX-License-Identifier: Apache-2.0
// The tool never passes through: plates and a wire of leaves, at many speeds and angles, 10^3 runs; SPHERETREE_LONG=1:
// 10^4 (about 3 minutes). Plates with a very thin skin, from both sides and with rotating tools, 10^4 runs;
// SPHERETREE_LONG=1: 10^5.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>

#include "spheretree/runtime/step.h"
#include "support/rig.h"

namespace spheretree::runtime {
namespace {

using test::kSpeeds;
using test::Random;
using test::Rig;
using test::thinPlate;

int runCount() { return std::getenv("SPHERETREE_LONG") ? 10000 : 300; }

struct Way {
  Eigen::Vector3d target, direction;
  Quaternion orientation;
  double before, after, step;  // [mm] along the way; a step above 40: one jump
};

/// True if the reference point of the graphic tool stays above z = 0 and its leaves outside those of the object.
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

// Smallest distance of a leaf's surface from the middle plane of the plate, on `side` (1: above).
double clearance(const SphereTree& tool, const Configuration& pose, double side) {
  double smallest = 1e9;
  for (const Sphere& leaf : test::leavesOf(tool)) {
    const double z = (pose.orientation * Eigen::Vector3d(leaf.x, leaf.y, leaf.z) + pose.position).z();
    smallest = std::min(smallest, side * z - static_cast<double>(leaf.radius));
  }
  return smallest;
}

TEST(Crossing, NoneOfPlatesWithASkin) {
  // The hand comes from one side in a straight line, rotating all the time, and ends on the other side.
  const int runs = std::getenv("SPHERETREE_LONG") ? 11112 : 1112;
  for (const double thickness : {0.2, 0.02, 0.0002}) {
    const std::array tools{test::oneBallTree(3), test::rodTree(10, 12, 0.6), test::boxTree({2, 2, 2}, {3, 3, 3}, 0.9)};
    for (std::size_t t = 0; t < tools.size(); ++t) {
      Rig rig(tools[t], thinPlate(thickness));
      Random random(100 * t + static_cast<std::uint64_t>(1e4 * thickness));
      int crossings = 0, penetrations = 0, contacts = 0;
      double smallest = 1e9;
      for (int run = 0; run < runs; ++run) {
        const double side = run % 2 ? 1 : -1, speed = kSpeeds[static_cast<std::size_t>(run) % kSpeeds.size()],
                     tilt = random.between(0, 1.2);
        Eigen::Vector3d way = downwards(tilt, random.between(0, 6.28));
        way.z() *= side;
        const Eigen::Vector3d target(random.between(-3, 3), random.between(-3, 3), 0);
        const Quaternion from = test::randomRotation(random);
        const Eigen::Vector3d turn = random.between(0, 0.1) * random.direction();  // in a step [rad]
        const double before = 14 / std::cos(tilt), after = std::min(10.0, 10 / std::max(std::sin(tilt), 1e-3));
        reset(*rig.workspace);
        int n = 0;
        for (double s = -before; s <= after; s += std::max(speed, 0.2 * (s < -9 / std::cos(tilt)))) {  // large steps through the air
          const Configuration haptic{target + way * s, (rotationOf(n++ * turn) * from).normalized()};
          const StepResult r = step(rig.scene, haptic, Mode::Constrained, *rig.workspace);
          const double clear = clearance(tools[t], r.graphic, side);
          smallest = std::min(smallest, clear);
          penetrations += r.penetration > kGapTolerance;
          contacts += r.active > 0;
          if (clear < -0.5 * 0.6) {
            ++crossings;
            break;
          }
        }
      }
      EXPECT_EQ(crossings, 0) << thickness << " mm, tool " << t;
      EXPECT_EQ(penetrations, 0) << thickness << " mm, tool " << t;
      EXPECT_GT(contacts, 2 * runs);
      // A skin of flat triangles has no tolerance: no leaf is deeper than the tolerance of gaps plus the rounding of
      // positions.
      EXPECT_GT(smallest, thickness / 2 - kGapTolerance - 1e-3) << thickness << " mm, tool " << t;
    }
  }
}

TEST(Crossing, ThePaperPassesThrough) {  // shows that these runs can detect it
  Rig rig(test::oneBallTree(5), test::boxTree({20, 20, 0}, {64, 64, 1}, 0.1));
  Random random(1);
  int crossings = 0;
  for (int run = 0; run < 10; ++run) crossings += !staysAbove(rig, wayOntoPlate(random, run), Mode::Published);
  EXPECT_GE(crossings, 9);
}

}  // namespace
}  // namespace spheretree::runtime
