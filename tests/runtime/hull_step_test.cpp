// SPDX-License-Identifier: Apache-2.0
// Steps of tools of hulls: force, torque and pose of closed forms, and that nothing passes through. Subject: step.h
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "spheretree/runtime/step.h"
#include "support/rig.h"
#include "support/sample_hulls.h"
#include "support/triangle_distance.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using test::degreesBetween;
using test::kUpright;
using test::Random;
using test::Rig;
using test::withSkin;

Quaternion turned(double angle, const Vector3d& axis) { return Quaternion(Eigen::AngleAxisd(angle, axis.normalized())); }

SphereTree ballObject(int times) { return withSkin(test::oneBallTree(5.2), test::roundSkin(times)); }

/// Moves to `haptic` in a straight line and stays there for a while.
StepResult pressTo(Rig& rig, const Configuration& from, const Configuration& haptic) {
  resetTo(from, *rig.workspace);
  StepResult r;
  for (int k = 1; k <= 100; ++k)
    r = rig.to({from.position + std::min(1.0, 0.02 * k) * (haptic.position - from.position), haptic.orientation});
  return r;
}

// A round plate 4 mm wide and 1 mm thick, pressed flat on a ball: no overhang holds it off.
TEST(HullStep, ADiscLiesOnABall) {
  Rig rig(test::toolOf(test::discHulls(1.5, 0.5, 22)), ballObject(5));
  Random random(1);
  double angle = 0, off = 0;
  for (int n = 0; n < 100; ++n) {
    const Vector3d way = random.direction();
    const Quaternion turn = Quaternion::FromTwoVectors(Vector3d::UnitZ(), way) * turned(random.between(0, 6.28), Vector3d::UnitZ());
    const StepResult r = pressTo(rig, {6 * way, turn}, {5 * way, turn});
    angle = std::max(angle, degreesBetween(r.wrench.force, way));
    off = std::max(off, std::abs(r.wrench.force.norm() - 0.5));
    ASSERT_EQ(r.faults, 0u);
    ASSERT_EQ(contacts(*rig.workspace).size(), 1u);
    ASSERT_NEAR((contacts(*rig.workspace)[0].point).norm(), 5, 2e-3)
        << r.graphic.position.norm() << " " << r.wrench.force.norm() << " " << contacts(*rig.workspace)[0].point.transpose() << " n "
        << contacts(*rig.workspace)[0].normal.transpose() << " way " << way.transpose();
  }
  EXPECT_LT(angle, 0.1);
  EXPECT_LT(off, 0.002);
}

// A disc that stands with its rim on a ball and turns about its own axis: the hand feels no corner of the rim.
TEST(HullStep, ARimThatTurnsIsRound) {
  Hulls disc = test::discHulls(1.5, 0.5, 27);
  disc.overhang_bound = 0.01f;
  Rig rig(test::toolOf(disc), ballObject(4));
  const Quaternion stands = turned(M_PI / 2, Vector3d::UnitX());
  pressTo(rig, {{0, 0, 7.5}, stands}, {{0, 0, 6.5}, stands});
  double least = 1, most = 0, angle = 0;
  for (int k = 0; k < 600; ++k) {
    const StepResult r = rig.to({{0, 0, 6.5}, turned(2e-3 * k, Vector3d::UnitY()) * stands});
    least = std::min(least, r.wrench.force.norm());
    most = std::max(most, r.wrench.force.norm());
    angle = std::max(angle, degreesBetween(r.wrench.force, Vector3d::UnitZ()));
    ASSERT_EQ(r.faults, 0u);
  }
  EXPECT_NEAR(least, 0.5, 1e-3);  // a rim of corners: 0.49, and 1.7 degrees
  EXPECT_NEAR(most, 0.5, 1e-3);
  EXPECT_LT(angle, 0.1);
}

// A rod lies on a box. Force and torque are those of the pressed pose: the box holds both ends.
TEST(HullStep, ARodOnAPlaneHasTheTorqueOfItsTilt) {
  for (const double radius : {0.5, 0.3}) {  // of the other end: a cone lies on its side
    Rig rig(test::toolOf(test::rodHulls({-4, 0, 0}, 0.5, {4, 0, 0}, radius)),
            withSkin(test::boxTree({10, 10, 2}, {10, 10, 2}, 2), test::boxSkin({10, 10, 2})));
    const double lies = std::asin((0.5 - radius) / 8), tilt = 0.001;
    const Quaternion flat = turned(lies, Vector3d::UnitY());
    // Pressed by 0.5 mm and tilted, but not so much that an end lifts off.
    const double height = 2 + 0.5 * (0.5 + radius) / std::cos(lies);
    const StepResult r = pressTo(rig, {{0.7, 0.2, height + 1}, flat}, {{0.7, 0.2, height - 0.5}, turned(tilt, Vector3d::UnitY()) * flat});
    EXPECT_NEAR(r.wrench.force.z(), 0.5, 1e-3);
    EXPECT_LT(r.wrench.force.head<2>().norm(), 1e-4);
    EXPECT_NEAR(r.wrench.torque.y(), -1000 * tilt, 0.005) << "a cone to radius " << radius;
    EXPECT_NEAR(std::abs(r.graphic.orientation.dot(flat)), 1, 1e-9);
    EXPECT_NEAR(r.graphic.position.z(), height, 2e-4);
    EXPECT_EQ(r.faults, 0u);
  }
}

// Drawn along its own axis over the edge of a box, a rod stands off by its radius, and turns by what the spring allows.
TEST(HullStep, ARodOnAnEdgeStandsOffByItsRadius) {
  Rig rig(test::toolOf(test::rodHulls({-6, 0, 0}, 0.4, {6, 0, 0}, 0.4)),
          withSkin(test::boxTree({10, 10, 2}, {10, 10, 2}, 2), test::boxSkin({10, 10, 2})));
  const Vector3d corner(10, 0, 2), out = Vector3d(1, 0, 1).normalized();  // the edge is along y
  for (int heading = 1; heading < 8; ++heading) {
    const Quaternion turn = turned(heading * M_PI / 8, out) * turned(M_PI / 2, Vector3d::UnitZ());
    const Vector3d along = turn * Vector3d::UnitX();
    resetTo({corner + 2 * out, turn}, *rig.workspace);
    for (int k = 0; k < 600; ++k) {
      const double arm = 0.005 * k;
      const StepResult r = rig.to({corner + arm * along + std::max(0.0, 2 - 0.01 * k) * out, turn});
      if (k < 250) continue;
      const double force = 0.4 / (1 + arm * arm / 1000);
      ASSERT_NEAR(r.wrench.force.norm(), force, 2e-4) << "heading " << heading << ", step " << k;
      ASSERT_NEAR(r.wrench.torque.norm(), force * arm, 2e-3) << "heading " << heading << ", step " << k;
      // The normal is perpendicular to the edge and to the rod, which the force turns.
      const double turn_of_normal = force * arm / 1000 / std::sin(heading * M_PI / 8);
      ASSERT_NEAR(degreesBetween(r.wrench.force, out), 180 / M_PI * turn_of_normal, 0.02) << "heading " << heading << ", step " << k;
    }
  }
}

// A cone in a groove of 90 degrees touches both walls along lines: its axis is where both ends are at their radii.
TEST(HullStep, AConeLiesInAGroove) {
  const SphereTree box = withSkin(test::boxTree({8, 8, 8}, {8, 8, 8}, 2), test::boxSkin({8, 8, 8}));
  SceneDescription d;
  d.tool = test::toolOf(test::rodHulls({0, -3, 0}, 0.8, {0, 3, 0}, 0.4));
  for (const double side : {-1.0, 1.0})  // two boxes, turned by 45 degrees: the walls are z = |x|
    d.objects.push_back({box, {Vector3d(side * 8 * std::sqrt(2.0), 0, 0), turned(M_PI / 4, Vector3d::UnitY())}});
  Rig rig(std::move(d));
  const Quaternion lies = turned(-std::asin(0.4 * std::sqrt(2.0) / 6), Vector3d::UnitX());
  const StepResult r = pressTo(rig, {{0, 0, 4}, lies}, {{0, 0, 0.2}, turned(5e-4, Vector3d::UnitX()) * lies});
  const Vector3d axis = r.graphic.orientation * Vector3d::UnitY();
  for (const double y : {-3.0, 3.0}) {
    const Vector3d centre = r.graphic.position + y * axis;
    EXPECT_NEAR((centre.z() - std::abs(centre.x())) / std::sqrt(2.0), y < 0 ? 0.8 : 0.4, 5e-4) << y;
  }
  EXPECT_NEAR(r.wrench.force.z(), 0.6 * std::sqrt(2.0) - 0.2, 1e-3);
  EXPECT_LT(r.wrench.force.head<2>().norm(), 1e-3);
  EXPECT_NEAR(r.wrench.torque.x(), -1000 * 5e-4, 0.01);
  EXPECT_EQ(r.faults, 0u);
}

// Whatever the hand does, the axis of a needle does not get into a plate by more than the tolerance of a step.
TEST(HullStep, NothingPassesThrough) {
  const Vector3d half(6, 6, 0.4);
  for (const Hulls& hulls : {test::rodHulls({0, 0, 0}, 0.1, {0, 0, 20}, 1, 12), test::discHulls(2, 0.3, 12)}) {
    Rig rig(test::toolOf(hulls), withSkin(test::boxTree(half, {12, 12, 2}, 0.7), test::boxSkin(half)));
    Random random(5);
    double deepest = 0;
    for (int run = 0; run < 40; ++run) {
      const Quaternion start = test::randomRotation(random);
      Configuration hand{30 * random.direction(), start};
      resetTo(hand, *rig.workspace);
      for (int k = 0; k < 150; ++k) {
        hand.position += random.inCube(1) - 0.05 * hand.position;
        hand.orientation = (turned(random.between(0, 0.1), random.direction()) * hand.orientation).normalized();
        const StepResult r = rig.to(hand);
        for (const HullPart& part : hulls.parts) {
          const Sphere &a = hulls.balls[part[0]], &b = hulls.balls[part[1] == kNoHullBall ? part[0] : part[1]];
          for (int i = 0; i <= 20; ++i) {
            const double w = i / 20.0;
            const Vector3d p = r.graphic.position + r.graphic.orientation * ((1 - w) * centreOf(a) + w * centreOf(b));
            const Vector3d beyond = (p.cwiseAbs() - half).cwiseMax(0);
            const double inside = std::min(0.0, (p.cwiseAbs() - half).maxCoeff());
            deepest = std::max(deepest, (1 - w) * double{a.radius} + w * double{b.radius} - (beyond.norm() + inside));
          }
        }
      }
    }
    EXPECT_LT(deepest, 0.012) << "hulls of " << hulls.parts.size() << " parts";
  }
}

// The same of an object with ridges, hollows and saddles, whose hollow sides and corners have no rows.
TEST(HullStep, NothingPassesThroughASurfaceWithHollows) {
  const Skin skin = test::facetedSkin(2);
  std::vector<Eigen::Matrix3d> corners, weights;
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
    const auto at = patchOf(skin, t).position;
    corners.emplace_back();
    for (int k = 0; k < 3; ++k) corners.back().col(k) = at[static_cast<std::size_t>(k)].cast<double>();
    weights.push_back(corners.back().inverse());
  }
  const auto distance = [&](const Vector3d& p) {
    double least = std::numeric_limits<double>::infinity();
    bool is_inside = false;  // seen whole from the origin
    for (std::size_t t = 0; t < corners.size(); ++t) {
      least = std::min(least, test::distanceToTriangle(p, {corners[t].col(0), corners[t].col(1), corners[t].col(2)}));
      const Vector3d w = weights[t] * p;
      is_inside = is_inside || (w.minCoeff() >= 0 && w.sum() <= 1);
    }
    return is_inside ? -least : least;
  };
  for (const Hulls& hulls : {test::rodHulls({0, 0, 0}, 0.1, {0, 0, 6}, 0.5, 4), test::discHulls(2, 0.3, 12)}) {
    Rig rig(test::toolOf(hulls), withSkin(test::oneBallTree(6.5), skin));
    Random random(6);
    double deepest = 0;
    int touched = 0;
    for (int run = 0; run < 20; ++run) {
      Configuration hand{12 * random.direction(), test::randomRotation(random)};
      resetTo(hand, *rig.workspace);
      for (int k = 0; k < 60; ++k) {
        hand.position += random.inCube(0.7) - 0.08 * hand.position;
        hand.orientation = (turned(random.between(0, 0.1), random.direction()) * hand.orientation).normalized();
        const StepResult r = rig.to(hand);
        if (r.active == 0) continue;
        ++touched;
        for (const HullPart& part : hulls.parts)
          for (int i = 0; i <= 4; ++i) {
            const double w = i / 4.0;
            const Sphere &a = hulls.balls[part[0]], &b = hulls.balls[part[1] == kNoHullBall ? part[0] : part[1]];
            const Vector3d c = r.graphic.position + r.graphic.orientation * ((1 - w) * centreOf(a) + w * centreOf(b));
            deepest = std::max(deepest, (1 - w) * double{a.radius} + w * double{b.radius} - distance(c));
          }
      }
    }
    EXPECT_GT(touched, 300);
    EXPECT_LT(deepest, 0.012) << "hulls of " << hulls.parts.size() << " parts";
  }
}

}  // namespace
}  // namespace spheretree::runtime
