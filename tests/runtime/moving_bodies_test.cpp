// SPDX-License-Identifier: Apache-2.0
// Bodies that move during rendering. Subject: moveBody() of step.h
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>

#include "spheretree/runtime/step.h"
#include "support/compiled_scene.h"
#include "support/rig.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using test::compiled;
using test::kSpeeds;
using test::kUpright;
using test::Random;
using test::thinPlate;

SceneDescription toolAndPlate(SphereTree tool, SphereTree plate) {
  SceneDescription d;
  d.tool = std::move(tool);
  d.objects.push_back({std::move(plate), {}, 1});
  return d;
}

// Smallest distance of a leaf's surface from the plate's middle plane, on the side of its z.
double clearance(const SphereTree& tool, const Configuration& pose, const Configuration& plate) {
  double smallest = 1e9;
  for (const Sphere& leaf : test::leavesOf(tool)) {
    const Vector3d world = pose.orientation * Vector3d(leaf.x, leaf.y, leaf.z) + pose.position;
    smallest = std::min(smallest, (plate.orientation.conjugate() * (world - plate.position)).z() - static_cast<double>(leaf.radius));
  }
  return smallest;
}

TEST(MovingBodies, ABodyThatStaysCostsNoByte) {
  Random random(3);
  SceneDescription still = toolAndPlate(test::rodTree(10, 12, 0.6), thinPlate(0.5)), moving = still;
  still.objects[0].body = 0;
  const Scene a = compiled(still), b = compiled(moving);
  Workspace of_a(a), of_b(b);
  for (int n = 0; n < 500; ++n) {
    const Configuration hand{{0.02 * n, 0, 8 - 0.03 * n}, rotationOf({0.003 * n, 0, 0})};
    ASSERT_TRUE(moveBody(1, {}, of_b));
    const StepResult ra = step(a, hand, Mode::Constrained, of_a), rb = step(b, hand, Mode::Constrained, of_b);
    ASSERT_EQ(ra.graphic.position, rb.graphic.position);
    ASSERT_EQ(ra.wrench.torque, rb.wrench.torque);
    ASSERT_EQ(ra.work, rb.work);
  }
}

TEST(MovingBodies, NothingIsPassedThrough) {
  // The hand rests, or moves against the plate; the plate comes from far away at 0.05 to 50 mm in each step, and
  // rotates.
  const int runs = std::getenv("SPHERETREE_LONG") ? 1112 : 112;
  for (const bool has_skin : {true, false})
    for (const double thickness : {0.5, 0.02}) {
      const std::array tools{test::oneBallTree(3), test::rodTree(10, 12, 0.6), test::boxTree({2, 2, 2}, {3, 3, 3}, 0.9)};
      for (std::size_t t = 0; t < tools.size(); ++t) {
        const Scene scene = compiled(toolAndPlate(tools[t], thinPlate(thickness, has_skin)));
        Workspace workspace(scene);
        Random random(10 * t + static_cast<std::uint64_t>(1e3 * thickness));
        int crossings = 0, penetrations = 0, contacts = 0, limits = 0;
        for (int run = 0; run < runs; ++run) {
          const double speed = kSpeeds[static_cast<std::size_t>(run) % kSpeeds.size()], tilt = random.between(0, 0.5);
          const Vector3d way = (test::randomRotation(random) * Vector3d::UnitZ()).normalized();
          const Quaternion facing = Quaternion::FromTwoVectors(Vector3d::UnitZ(), way);
          const Vector3d axis = random.direction();
          const Configuration rest{random.direction() * random.between(0, 2), test::randomRotation(random)};
          reset(workspace);
          for (double s = -22; s <= 12; s += std::max(speed, 0.2 * (s < -16))) {
            Configuration plate{way * s, rotationOf(axis * (tilt * (s - 5) / 40)) * facing};
            if (s == -22) reset(workspace);
            ASSERT_TRUE(moveBody(1, plate, workspace));
            const Configuration hand{rest.position - way * (0.1 * (s + 22)), rest.orientation};
            const StepResult r = step(scene, hand, Mode::Constrained, workspace);
            const Configuration at = bodyPose(1, workspace);
            limits += (r.faults & kWorkLimit) != 0;
            penetrations += r.penetration > kGapTolerance;
            contacts += r.active > 0;
            if (clearance(tools[t], r.graphic, at) < -0.5) {
              ++crossings;
              break;
            }
          }
        }
        EXPECT_EQ(crossings, 0) << has_skin << ' ' << thickness << " mm, tool " << t;
        EXPECT_EQ(penetrations, 0) << has_skin << ' ' << thickness << " mm, tool " << t;
        EXPECT_GT(contacts, 2 * runs);
        EXPECT_LT(limits, contacts / 4);
      }
    }
}

TEST(MovingBodies, AHandThatIsCarriedAlongFeelsTheSame) {
  // Plate and hand move together through the world: the wrench is that of a plate and a hand at rest, in rotated axes.
  const Scene scene = compiled(toolAndPlate(test::boxTree({2, 2, 2}, {3, 3, 3}, 0.9), thinPlate(0.5)));
  Workspace still(scene), moving(scene);
  const Configuration above{{1, 2, 6}, rotationOf({0.1, 0.2, 0})};
  double worst = 0, deepest = 0;
  for (int n = 0; n < 1000; ++n) {
    const Configuration hand{above.position - Vector3d(0, 0, std::min(0.02 * n, 4.5)), above.orientation};
    const Quaternion turn = rotationOf({0.0005 * n, 0.001 * n, 0});
    const Vector3d place(0.1 * n, 5 * std::sin(0.01 * n), 0.03 * n);
    ASSERT_TRUE(moveBody(1, {place, turn}, moving));
    const StepResult a = step(scene, hand, Mode::Constrained, still);
    const StepResult b = step(scene, {turn * hand.position + place, turn * hand.orientation}, Mode::Constrained, moving);
    worst = std::max(worst, (turn * a.wrench.force - b.wrench.force).norm());
    deepest = std::max(deepest, b.penetration);
  }
  EXPECT_LT(worst, 0.01);
  EXPECT_LE(deepest, kGapTolerance);
}

// Two plates that face each other, bodies 1 and 2.
SceneDescription jaws() {
  SceneDescription d = toolAndPlate(test::oneBallTree(1), thinPlate(2));
  d.objects.push_back({d.objects[0].tree, {}, 2});
  return d;
}

TEST(MovingBodies, ACrushedToolIsHeldAndComesFree) {
  const Scene scene = compiled(jaws());
  for (const double speed : {0.05, 0.5}) {
    Workspace workspace(scene);
    double opening = 6, deepest_free = 0;
    bool told = true, is_shallow = true;
    StepResult r;
    const auto close = [&](double to) {
      while (std::abs(opening - to) > 1e-9) {
        opening += std::clamp(to - opening, -speed, speed);
        moveBody(1, {{0, 0, -1 - opening / 2}, kUpright}, workspace);
        moveBody(2, {{0, 0, 1 + opening / 2}, kUpright}, workspace);
        r = step(scene, {{0, 0, 0.3}, kUpright}, Mode::Constrained, workspace);
        if (opening >= 2) deepest_free = std::max(deepest_free, r.penetration);
        const double crush = 1 - opening / 2;
        if (crush > 0.01) told = told && (r.faults & kRowsConflict) && (r.faults & kPenetrating);
        if (crush > 0.01 && is_shallow) {
          EXPECT_NEAR(r.graphic.position.z(), 0, 0.01) << opening;
          EXPECT_NEAR(r.penetration, crush, 0.01) << opening;
        }
        EXPECT_LE(r.limited_wrench.force.norm(), 8 + 1e-9);
      }
    };
    close(1.6);
    EXPECT_TRUE(told);
    close(6);
    is_shallow = false;  // deeper than half the ball, where the side of the skin is determined again
    close(0.8);
    EXPECT_TRUE(r.faults & kPenetrating);
    close(6);
    EXPECT_LE(deepest_free, 0.01);
    for (int n = 0; n < 20; ++n) r = step(scene, {{0, 0, 0.3}, kUpright}, Mode::Constrained, workspace);
    EXPECT_EQ(r.faults, 0u);
    EXPECT_LT((r.graphic.position - Vector3d(0, 0, 0.3)).norm(), 1e-6);
  }
}

TEST(MovingBodies, VelocityGoesOnBetweenPoses) {
  const Scene scene = compiled(toolAndPlate(test::oneBallTree(1), thinPlate(2)));
  Workspace workspace(scene);
  step(scene, {{0, 0, 3}, kUpright}, Mode::Constrained, workspace);
  ASSERT_TRUE(moveBody(1, {}, workspace, {{0, 0, 100}, {0, 0, 1}}));
  for (int n = 0; n <= 50; ++n) step(scene, {{0, 0, 3}, kUpright}, Mode::Constrained, workspace);
  EXPECT_NEAR(bodyPose(1, workspace).position.z(), 5, 1e-9);
  EXPECT_NEAR(rotationVector(bodyPose(1, workspace).orientation).z(), 0.05, 1e-9);
  const StepResult r = step(scene, {{0, 0, 3}, kUpright}, Mode::Constrained, workspace);
  EXPECT_NEAR(r.graphic.position.z(), 5.1 + 2, 2e-3);  // pushed ahead
  ASSERT_TRUE(moveBody(1, {}, workspace));
  for (int n = 0; n < 20; ++n) step(scene, {{0, 0, 3}, kUpright}, Mode::Constrained, workspace);
  EXPECT_EQ(bodyPose(1, workspace).position, Vector3d(0, 0, 0));
}

// An object of a body that is away is moved, before or after the body gets its next pose: the order is of no effect.
TEST(MovingBodies, AnObjectOfABodyThatIsAwayMayBeMoved) {
  const Scene scene = compiled(toolAndPlate(test::oneBallTree(1), thinPlate(2)));
  Workspace a(scene), b(scene);
  const Configuration near{{0, 0, -20}, kUpright}, moved_to{{5, 0, -303}, rotationOf({1.2, 0, 0})};
  for (Workspace* workspace : {&a, &b})
    for (int n = 0; n <= 3; ++n) {
      ASSERT_TRUE(moveBody(1, {{0, 0, -300.0 - n}, rotationOf({0.4 * n, 0, 0})}, *workspace));
      step(scene, {{0, 0, 3}, kUpright}, Mode::Constrained, *workspace);
    }
  ASSERT_TRUE(moveObject(0, moved_to, a));
  ASSERT_TRUE(moveBody(1, near, a));
  ASSERT_TRUE(moveBody(1, near, b));
  ASSERT_TRUE(moveObject(0, moved_to, b));
  for (int n = 0; n < 200; ++n) {
    const Configuration hand{{0, 0, 3 - 0.2 * n}, kUpright};
    const StepResult of_a = step(scene, hand, Mode::Constrained, a), of_b = step(scene, hand, Mode::Constrained, b);
    ASSERT_EQ(of_a.graphic.position, of_b.graphic.position) << n;
    if (n == 199) {
      EXPECT_NEAR(of_a.graphic.position.z(), -20 + 2, 0.05);  // held by the plate
    }
  }
}

// A body that is away continues with its velocity, and the tool meets it where it has got to.
TEST(MovingBodies, VelocityGoesOnFarAway) {
  const Scene scene = compiled(toolAndPlate(test::oneBallTree(1), thinPlate(2)));
  Workspace workspace(scene);
  ASSERT_TRUE(moveBody(1, {{0, 0, -300}, kUpright}, workspace, {{0, 0, 1000}, {0, 0, 0}}));
  StepResult r;
  for (int n = 0; n <= 280; ++n) {
    r = step(scene, {{0, 0, 3}, kUpright}, Mode::Constrained, workspace);
    ASSERT_NEAR(bodyPose(1, workspace).position.z(), -300 + n, 1e-9);
    ASSERT_EQ(r.graphic.position, Vector3d(0, 0, 3));
  }
  for (int n = 281; n <= 310; ++n) r = step(scene, {{0, 0, 3}, kUpright}, Mode::Constrained, workspace);
  EXPECT_NEAR(bodyPose(1, workspace).position.z(), 10, 1e-9);
  EXPECT_NEAR(r.graphic.position.z(), 10 + 2, 2e-3);  // pushed ahead
}

// A plate sways a little: the tool goes on in the piece in which it arrives, so a step needs no more pieces than with a
// plate at rest; and a tool that nothing holds arrives exactly.
TEST(MovingBodies, TheToolGoesOnWhileBodiesArrive) {
  const SceneDescription d = toolAndPlate(test::oneBallTree(1), thinPlate(2));
  const Scene scene = compiled(d);
  Workspace still(scene), moving(scene);
  std::uint32_t pieces_still = 0, pieces_moving = 0;
  int touching = 0;
  for (int n = 0; n < 1000; ++n) {
    const Configuration hand{{0.01 * n, 0, 4 - 3 * std::sin(0.01 * n)}, rotationOf({0.1, 0.05, 0})};
    const Vector3d way(0.05 * std::sin(0.02 * n), 0.05 * std::cos(0.02 * n), 0.02 * std::sin(0.03 * n));
    ASSERT_TRUE(moveBody(1, {way, rotationOf(0.02 * way)}, moving));
    pieces_still += step(scene, hand, Mode::Constrained, still).linearisations;
    const StepResult r = step(scene, hand, Mode::Constrained, moving);
    pieces_moving += r.linearisations;
    ASSERT_LE(r.penetration, kGapTolerance);
    touching += r.active > 0;
    if (r.active == 0 && r.graphic.position != hand.position)
      ADD_FAILURE() << "step " << n << " ends " << (r.graphic.position - hand.position).norm() << " mm from the hand";
  }
  EXPECT_GT(touching, 200);
  EXPECT_LT(touching, 800);
  EXPECT_LT(pieces_moving, 1.1 * pieces_still);
}

TEST(MovingBodies, RefusesInvalidPoses) {
  const Scene scene = compiled(toolAndPlate(test::oneBallTree(1), thinPlate(2)));
  EXPECT_EQ(scene.bodyCount(), 2u);
  Workspace workspace(scene);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(moveBody(0, {}, workspace));
  EXPECT_FALSE(moveBody(2, {}, workspace));
  EXPECT_FALSE(moveBody(1, {{nan, 0, 0}, kUpright}, workspace));
  EXPECT_FALSE(moveBody(1, {{0, 2e7, 0}, kUpright}, workspace));
  EXPECT_FALSE(moveBody(1, {{0, 0, 0}, Quaternion(0, 0, 0, 0)}, workspace));
  EXPECT_FALSE(moveBody(1, {}, workspace, {{nan, 0, 0}, {0, 0, 0}}));
  step(scene, {{0, 0, 3}, kUpright}, Mode::Constrained, workspace);
  EXPECT_EQ(bodyPose(1, workspace).position, Vector3d(0, 0, 0));
}

// A body is moved about where the tool is not; then the tool comes to it, and feels what it would if the plate had
// always been there.
TEST(MovingBodies, ABodyThatWasFarAwayIsMetWhereItsPoseSays) {
  Random random(11);
  for (int run = 0; run < 20; ++run) {
    const Configuration place{test::randomPoint(random, 60), test::randomRotation(random)};
    SceneDescription moving = toolAndPlate(test::rodTree(6, 8, 0.6), thinPlate(0.5)), still = moving;
    still.objects[0].body = 0;
    still.objects[0].pose = place;
    const Scene with = compiled(moving), without = compiled(still);
    Workspace of_moving(with), of_still(without);
    const Configuration far{place.position + place.orientation * Vector3d(0, 0, 300), place.orientation};
    for (int n = 0; n < 30; ++n) {
      const Configuration on_the_way = moved(place, {test::randomPoint(random, 20), test::randomPoint(random, 1)});
      const Configuration before = bodyPose(1, of_moving), to = n < 29 ? on_the_way : place;
      ASSERT_TRUE(moveBody(1, to, of_moving));
      EXPECT_EQ(bodyPose(1, of_moving).position, before.position);  // it moves in the step
      step(with, far, Mode::Constrained, of_moving);
      EXPECT_EQ(bodyPose(1, of_moving).position, to.position);
      step(without, far, Mode::Constrained, of_still);
    }
    bool is_touched = false;
    for (int n = 0; n < 200; ++n) {
      const Vector3d hand(0.05 * n, 0.02 * n, n < 5 ? 5 : std::max(-3.0, 5 - 0.1 * n));
      const Configuration pose{place.position + place.orientation * hand, place.orientation};
      const StepResult a = step(with, pose, Mode::Constrained, of_moving), b = step(without, pose, Mode::Constrained, of_still);
      ASSERT_LT((a.wrench.force - b.wrench.force).norm(), 1e-3) << run << ' ' << n;
      ASSERT_LT((a.graphic.position - b.graphic.position).norm(), 1e-3);
      ASSERT_LE(a.penetration, kGapTolerance);
      is_touched = is_touched || a.active > 0;
    }
    EXPECT_TRUE(is_touched);
  }
}

}  // namespace
}  // namespace spheretree::runtime
