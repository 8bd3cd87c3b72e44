// SPDX-License-Identifier: GPL-3.0-or-later
// The measures of the stability bench against closed forms, and against inserted faults: a measure that misses them is
// defective.
#include "scenarios/measures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "run/run_statistics.h"
#include "spheretree/builder/mesh_checks.h"
#include "support/sample_skins.h"
#include "support/shape_trees.h"

namespace spheretree::player {
namespace {

using test::Random;
const Quaternion kUpright(1, 0, 0, 0);

Body bodyOf(TriangleMesh mesh, SphereTree tree) {
  builder::DistanceField field(mesh);
  return {"body", std::move(mesh), std::move(tree), std::move(field)};
}

/// Nearest point of {signed distance to the solid >= r} by search: rings of shrinking size around the best point so
/// far.
template <class Distance>
Eigen::Vector3d nearestFree(const Eigen::Vector3d& haptic, double r, const Distance& distance) {
  Eigen::Vector3d best(0, 0, 0);
  double best2 = 1e300;
  const auto offer = [&](const Eigen::Vector3d& p) {
    if (distance(p) >= r - 1e-12 && (p - haptic).squaredNorm() < best2) best2 = (p - haptic).squaredNorm(), best = p;
  };
  offer(haptic);
  for (int i = -60; i <= 60; ++i)
    for (int k = -60; k <= 60; ++k) offer(haptic + Eigen::Vector3d(0.2 * i, 0, 0.2 * k));
  for (double size = 0.2; size > 1e-9; size *= 0.7) {
    const Eigen::Vector3d centre = best;
    for (int i = 0; i < 64; ++i) {
      const double a = 2 * std::numbers::pi * i / 64;
      offer(centre + size * Eigen::Vector3d(std::cos(a), 0, std::sin(a)));
    }
  }
  return best;
}

TEST(Measures, OffsetAnswersAreTheNearestFreePoints) {
  Random random(1);
  const double half_angle = std::numbers::pi / 6, s = std::sin(half_angle), c = std::cos(half_angle);
  const auto edge = [](const Eigen::Vector3d& p) {
    const Eigen::Vector2d out(std::max(p.x(), 0.0), std::max(p.z(), 0.0));
    return out.norm() > 0 ? out.norm() : std::max(p.x(), p.z());
  };
  const auto groove = [&](const Eigen::Vector3d& p) { return s * p.z() - c * std::abs(p.x()); };
  for (int n = 0; n < 60; ++n) {
    const Eigen::Vector3d h(random.between(-3, 3), random.between(-5, 5), random.between(-3, 3));
    const auto agree = [&](const Eigen::Vector3d& answer, const Eigen::Vector3d& searched, const char* what) {
      EXPECT_NEAR((answer - h).norm(), (searched - h).norm(), 5e-3) << what << " at " << h.transpose();
    };
    agree(offsetEdge(h, 1), nearestFree(h, 1, edge), "edge");
    agree(offsetGroove(h, 1, half_angle), nearestFree(h, 1, groove), "groove");
    // And free themselves.
    EXPECT_GE(edge(offsetEdge(h, 1)), 1 - 1e-9);
    EXPECT_GE(groove(offsetGroove(h, 1, half_angle)), 1 - 1e-9);
  }
}

/// A tool of a burr and a shank above it, and a block below z = 0.
struct CutRig {
  Body tool = bodyOf(box({-1, -1, -1}, {1, 1, 9}),
                     test::treeOfBalls({test::ball(0, 0, 0, 0.5), test::ball(0, 0, 0.7, 0.3), test::ball(0, 0, 1.5, 0.3)}));
  Body block = bodyOf(box({-5, -5, -5}, {5, 5, 0}), {});
  CutPenetration cut{tool, Eigen::Vector3d::Zero(), {&block, {}}, {{Eigen::Vector3d::Zero(), 0.5}}};
  void to(const Eigen::Vector3d& p, bool cuts) { cut.moveTo({p, kUpright}, cuts); }
};

TEST(Measures, WhatABurrLeavesIsTheBlockWithoutItsCapsules) {
  CutRig rig;
  rig.to({0, 0, 2}, true);
  rig.to({0, 0, -1}, true);
  for (int n = 1; n <= 100; ++n) rig.to({0.01 * n, 0, -1}, true);  // one line of many steps
  const auto exact = [](const Eigen::Vector3d& p) {
    const double down = std::hypot(p.x(), p.y(), std::max(0.0, -1 - p.z())),
                 aside = std::hypot(p.x() - std::clamp(p.x(), 0.0, 1.0), p.y(), p.z() + 1);
    return std::min({-p.z(), 5 + p.z(), down - 0.5, aside - 0.5});
  };
  Random random(2);
  for (int n = 0; n < 2000; ++n) {
    const Eigen::Vector3d p(random.between(-1, 2), random.between(-1, 1), random.between(-2, -0.1));
    EXPECT_NEAR(rig.cut.depthAt(p), exact(p), 2e-3);
  }
}

TEST(Measures, PartsThatDoNotCutAreFoundInTheMaterial) {
  CutRig rig;
  rig.to({0, 0, 2}, true);
  rig.to({0, 0, -1}, true);
  EXPECT_EQ(rig.cut.depth(), 0);  // the shank has room in the hole
  rig.to({0.19, 0, -1}, true);
  EXPECT_EQ(rig.cut.depth(), 0);
  rig.to({0.3, 0, -1}, true);
  EXPECT_NEAR(rig.cut.depth(), 0.1, 0.005);  // the shank, beside the hole of the burr's way
  EXPECT_EQ(rig.cut.passages(), 0);
  rig.to({1, 0, -1}, true);  // its axis as well
  EXPECT_EQ(rig.cut.passages(), 1);
  CutRig firm;
  firm.to({0, 0, 2}, true);
  firm.to({0, 0, 0.45}, false);
  EXPECT_NEAR(firm.cut.depth(), 0.05, 0.002);  // the burr that does not spin
  EXPECT_EQ(firm.cut.passages(), 0);
  firm.to({0, 0, -0.2}, false);
  EXPECT_EQ(firm.cut.passages(), 1);
  // Through a wall within one way.
  Body wall = bodyOf(box({-5, -5, -0.2}, {5, 5, 0}), {});
  CutPenetration cut(firm.tool, Eigen::Vector3d::Zero(), {&wall, {}}, {{Eigen::Vector3d::Zero(), 0.5}});
  cut.moveTo({{0, 0, 0.6}, kUpright}, true);
  cut.moveTo({{0, 0, 20}, kUpright}, false);
  EXPECT_EQ(cut.passages(), 0);
  cut.moveTo({{0, 0, -20}, kUpright}, false);
  EXPECT_EQ(cut.passages(), 1);
}

/// A ball on an exact plane: the rows of a perfect renderer.
std::vector<RecordedStep> ballOnPlane() {
  std::vector<RecordedStep> rows;
  for (int n = 0; n < 400; ++n) {
    RecordedStep row;
    row.tick = static_cast<std::uint64_t>(n);
    row.haptic.position = {0.05 * n, 0, 3 + std::cos(0.03 * n)};
    row.graphic.position = {row.haptic.position.x(), 0, std::max(row.haptic.position.z(), 3.0)};
    row.wrench.force = row.graphic.position - row.haptic.position;
    rows.push_back(row);
  }
  return rows;
}

TEST(Measures, APerfectRendererPasses) {
  const auto rows = ballOnPlane();
  EXPECT_LE(largestLRatio(rows, {}), 1 + 1e-9);
  EXPECT_LE(largestForceJump(rows, {}), 1e-9);
  EXPECT_LE(largestTorqueJump(rows, {}), 1e-9);
}

TEST(Measures, PlantedFaultsShow) {
  auto wrong_sign = ballOnPlane();
  for (std::size_t n = 100; n < 103; ++n) wrong_sign[n].wrench.force *= -1;
  EXPECT_GT(largestLRatio(wrong_sign, {}), 5);
  EXPECT_GT(largestForceJump(wrong_sign, {}), 5);

  auto delayed = ballOnPlane();  // 30 steps the same force, then the right one
  for (std::size_t n = 130; n < 160; ++n) delayed[n].wrench = delayed[129].wrench;
  EXPECT_GT(largestLRatio(delayed, {}), 3);
  EXPECT_GT(largestForceJump(delayed, {}), 1);

  auto twisted = ballOnPlane();
  twisted[50].wrench.torque = {0, 8, 0};
  EXPECT_GT(largestTorqueJump(twisted, {}), 1);
}

TEST(Measures, ADroppedPairShowsAsPenetrationOfLeaves) {
  // Two balls of an object; the tool is placed as by a renderer that knows only the first.
  const Body tool = bodyOf(box({-1, -1, -1}, {1, 1, 1}), test::oneBallTree(2));
  const Body object = bodyOf(box({-1, -1, -1}, {1, 1, 1}), test::treeOfBalls({test::ball(0, 0, 0, 3), test::ball(4, 0, 0, 3)}));
  LeafPenetration measure(tool.tree, {0, 0, 0}, std::vector<PlacedBody>{{&object, {}}}, runtime::ContactSurface::Leaves);
  EXPECT_EQ(measure.at({{-5, 0, 0}, kUpright}), 0);
  EXPECT_NEAR(measure.at({{0, 0, 5}, kUpright}), 0, 1e-9);            // free of both
  EXPECT_NEAR(measure.at({{4, 0, 5 - 0.25}, kUpright}), 0.25, 1e-6);  // the second pair, dropped
}

TEST(Measures, PenetrationOfLeavesIsTheSameWhereverTheToolComesFrom) {
  // One measure follows a rod that slides, rotates and rests in turn, in and out of a bed of balls that moves while the
  // rod rests; another measure starts anew at each pose.
  const Body tool = bodyOf(box({-1, -1, -1}, {1, 1, 1}), test::rodTree(40, 30, 1));
  const Body object = bodyOf(box({-1, -1, -1}, {1, 1, 1}), test::boxTree({20, 20, 0}, {20, 20, 1}, 1.5));
  const std::vector<PlacedBody> objects{{&object, {}}};
  LeafPenetration follows(tool.tree, {0, 0, 15}, objects, runtime::ContactSurface::Skin);  // it has none
  int inside = 0, outside = 0;
  double slid = 0, turned = 0, bed = 0;
  for (int n = 0; n < 900; ++n) {
    const int phase = n / 20 % 3;
    slid += 0.05 * (phase == 0);
    turned += 0.05 * (phase == 1);
    if (n % 60 == 50) {
      const double way = n % 120 == 50 ? 2 : -2;
      follows.moveObject(0, {0, 0, way});
      bed += way;
    }
    LeafPenetration fresh(tool.tree, {0, 0, 15}, objects, runtime::ContactSurface::Skin);
    fresh.moveObject(0, {0, 0, bed});
    const Configuration pose{{3 * std::sin(slid), 0, 6 + 4 * std::cos(slid)}, rotationOf({1.5 + 0.5 * std::sin(turned), 0, 0})};
    const double depth = follows.at(pose);
    ASSERT_EQ(depth, fresh.at(pose)) << n;
    ++(depth > 0 ? inside : outside);
  }
  EXPECT_GT(inside, 100);
  EXPECT_GT(outside, 100);
}

TEST(Measures, PenetrationOfASkinIsThatOfTheMeshBeyondItsTolerances) {
  // A leaf about the box reaches far out of it, which matters only where leaves are the contact surface.
  const Body tool = bodyOf(box({-1, -1, -1}, {1, 1, 1}), test::oneBallTree(2));
  SphereTree tree = test::withSkin(test::oneBallTree(18), test::boxSkin({10, 10, 10}));
  tree.skin.tolerance = 0.03f;
  tree.skin.mesh_distance = 0.02f;
  const Body object = bodyOf(box({-10, -10, -10}, {10, 10, 10}), std::move(tree));
  const std::vector<PlacedBody> objects{{&object, {{0, 0, 5}, kUpright}}};
  LeafPenetration skin(tool.tree, {0, 0, 0}, objects, runtime::ContactSurface::Skin),
      leaves(tool.tree, {0, 0, 0}, objects, runtime::ContactSurface::Leaves);
  EXPECT_NEAR(skin.at({{3, 2, 17}, kUpright}), 0, 1e-9);
  EXPECT_NEAR(skin.at({{3, 2, 16.8}, kUpright}), 0.2 - 0.05, 1e-6);
  EXPECT_NEAR(skin.at({{11, 2, 16}, kUpright}), 2 - std::sqrt(2.0) - 0.05, 1e-6);  // over an edge
  EXPECT_NEAR(leaves.at({{0, 0, 17}, kUpright}), 8, 1e-6);
  skin.moveObject(0, {0, 0, 1});
  EXPECT_NEAR(skin.at({{3, 2, 17.8}, kUpright}), 0.2 - 0.05, 1e-6);
}

TEST(Measures, PenetrationOfMeshesIsExactForBoxes) {
  const Body tool = bodyOf(box({-1, -1, -1}, {1, 1, 1}), test::oneBallTree(2)),
             object = bodyOf(box({-5, -5, -5}, {5, 5, 5}), test::oneBallTree(9));
  const MeshPenetration measure(tool, {0, 0, 1}, {{&object, {{0, 0, 10}, kUpright}}}, 0.5);
  EXPECT_EQ(measure.at({{0, 0, 4.9}, kUpright}), 0);  // its top at 4.9, the object's bottom at 5
  EXPECT_NEAR(measure.at({{0, 0, 5.3}, kUpright}), 0.3, 1e-12);
  EXPECT_NEAR(measure.at({{5.2, 0, 8}, kUpright}), 0.8, 1e-12);      // by the side, 1 + 5 - 5.2
  EXPECT_GT(measure.at({{0, 0, 4.8}, rotationOf({0.6, 0, 0})}), 0);  // turned up into it
}

// Against a test of every point.
TEST(Measures, PenetrationOfMeshesIsTheDeepestOfAllPoints) {
  const Body tool = bodyOf(box({-1, -2, -0.5}, {1, 2, 0.5}), test::oneBallTree(3)),
             object = bodyOf(extrude({{-4, -4}, {4, -4}, {4, 0}, {0, 0}, {0, 4}, {-4, 4}}, 8), test::oneBallTree(9));
  const Configuration place{{1, 2, 3}, rotationOf({0.2, -0.4, 0.1})};
  const Eigen::Vector3d reference_point(0.5, 0, 1);
  const MeshPenetration measure(tool, reference_point, {{&object, place}}, 0.4);
  Random random(5);
  int deep = 0;
  for (int n = 0; n < 300; ++n) {
    const Configuration pose{place.position + random.inBox({-6, -6, -6}, {6, 6, 6}), rotationOf(random.inBox({-2, -2, -2}, {2, 2, 2}))};
    double deepest = 0;
    const auto look = [&](const Body& body, const Eigen::Vector3d& p) { deepest = std::max(deepest, -body.field.signedDistance(p)); };
    for (const Eigen::Vector3d& p : surfacePoints(tool.mesh, 0.4))
      look(object, place.orientation.conjugate() * (pose.orientation * (p - reference_point) + pose.position - place.position));
    for (const Eigen::Vector3d& p : surfacePoints(object.mesh, 0.4))
      look(tool, pose.orientation.conjugate() * (place.orientation * p + place.position - pose.position) + reference_point);
    EXPECT_NEAR(measure.at(pose), deepest, 1e-12);
    deep += deepest > 0.1;
  }
  EXPECT_GT(deep, 50);
  EXPECT_LT(deep, 290);
}

TEST(Measures, EnergyOfAnIdealSpringComesBack) {
  PassivityObserver calm, leaky;
  for (int n = 0; n <= 2000; ++n) {
    const double x = 1 - std::cos(2 * std::numbers::pi * n / 2000), before = 1 - std::cos(2 * std::numbers::pi * (n - 1) / 2000);
    Wrench spring, late;
    spring.force = {-0.5 * (x + 1 - std::cos(2 * std::numbers::pi * (n + 1) / 2000)), 0, 0};  // the mean over the next step: no leak
    late.force = {-before, 0, 0};
    calm.add({{x, 0, 0}, kUpright}, spring);
    leaky.add({{x, 0, 0}, kUpright}, late);
  }
  EXPECT_NEAR(calm.energy(), 0, 1e-9);
  EXPECT_NEAR(calm.largest(), 2, 1e-5);  // k x^2 / 2 at x = 2
  // A force that is one step late gives (1/2 + 1) T k v^2 away: the sum of 1.5 dx^2.
  double expected = 0;
  for (int n = 1; n <= 2000; ++n) {
    const double dx = std::cos(2 * std::numbers::pi * (n - 1) / 2000) - std::cos(2 * std::numbers::pi * n / 2000);
    expected += 1.5 * dx * dx;
  }
  EXPECT_NEAR(-leaky.energy(), expected, 0.01 * expected);
}

TEST(Measures, QuantilesOfTimes) {
  TimeHistogram h;
  for (int i = 1; i <= 1000; ++i) h.add(i);
  EXPECT_NEAR(h.quantile(0.5), 500, 8);
  EXPECT_NEAR(h.quantile(0.99), 990, 12);
  EXPECT_EQ(h.largest(), 1000);
  EXPECT_EQ(h.quantile(1), 1000);
  EXPECT_EQ(TimeHistogram().quantile(0.5), 0);
}

TEST(ScenarioShapes, AreCleanMeshesOfTheRightVolume) {
  const TriangleMesh cube = box({-1, -2, -3}, {1, 2, 3});
  const TriangleMesh groove = extrude({{-10, -4}, {10, -4}, {10, 10}, {5, 10}, {0, 0}, {-5, 10}, {-10, 10}}, 20);
  const TriangleMesh can = lathe({{0, -1}, {2, -1}, {2, 1}, {0, 1}}, 6);
  const auto volumeOf = [](const TriangleMesh& mesh) {
    const builder::MeshReport report = builder::checkMesh(mesh);
    EXPECT_TRUE(report.clean()) << report.summary();
    return report.volume;
  };
  EXPECT_NEAR(volumeOf(cube), 48, 1e-9);
  EXPECT_NEAR(volumeOf(groove), 20 * (20 * 14 - 50), 1e-9);
  const TriangleMesh cut = refined(groove, [](const Eigen::Vector3d& p) { return 1 + p.norm() / 2; });
  EXPECT_NEAR(volumeOf(cut), volumeOf(groove), 1e-9);
  for (std::size_t t = 0; t < cut.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d &a = cut.corner(t, k), &b = cut.corner(t, (k + 1) % 3);
      EXPECT_LE((b - a).norm(), 1.5 * (1 + (a + b).norm() / 4));
    }
  EXPECT_NEAR(volumeOf(can), 2 * 6 * 0.5 * 4 * std::sin(std::numbers::pi / 3), 1e-9);
}

}  // namespace
}  // namespace spheretree::player
