// SPDX-License-Identifier: Apache-2.0
#include "spheretree/runtime/bridge.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "spheretree/runtime/step.h"
#include "support/shape_trees.h"

namespace spheretree::runtime {
namespace {

using test::Random;

/// A sheet of equal balls in hexagonal order, 2 apart, whose tree states an overhang of `stated`.
SceneDescription sheet(double stated, bool bridges) {
  std::vector<Sphere> balls;
  for (int row = 0; row < 14; ++row)
    for (int i = 0; i < 12; ++i) balls.push_back(test::ball(2 * i + row % 2 - 12, std::sqrt(3.0) * row - 12, 0, 2));
  SceneDescription d;
  d.tool = test::oneBallTree(1);
  d.objects.push_back({test::treeOfBalls(balls), {}});
  d.objects[0].tree.statistics.back().overhang_bound = static_cast<float>(stated);
  d.bridges = bridges;
  return d;
}

Scene compiled(const SceneDescription& d) {
  Scene scene;
  std::string fault;
  EXPECT_TRUE(compileScene(d, scene, fault)) << fault;
  return scene;
}

/// Largest sideways force over the mean normal one, and the deepest the runtime says, sliding 1 below the flat top.
double ripple(const Scene& scene, double& penetration) {
  Workspace workspace(scene);
  double side = 0, normal = 0;
  int count = 0;
  const Eigen::Vector3d way(std::cos(0.3), std::sin(0.3), 0);
  for (double z = 5; z > 2; z -= 0.05) step(scene, {-4 * way + Eigen::Vector3d(0, 0, z), {1, 0, 0, 0}}, Mode::Constrained, workspace);
  for (double s = -4; s < 4; s += 0.05) {
    const StepResult r = step(scene, {s * way + Eigen::Vector3d(0, 0, 2), {1, 0, 0, 0}}, Mode::Constrained, workspace);
    side = std::max(side, r.wrench.force.head<2>().norm());
    normal += r.wrench.force.z();
    ++count;
    penetration = std::max(penetration, r.penetration);
  }
  return side / (normal / count);
}

TEST(Bridge, ASheetOfEqualBallsBecomesFlat) {
  double penetration = 0;
  const double bumps = ripple(compiled(sheet(0.5, false)), penetration), flat = ripple(compiled(sheet(0.5, true)), penetration);
  EXPECT_GT(bumps, 0.1);
  EXPECT_LT(flat, 1e-3);
  EXPECT_LE(penetration, kGapTolerance);
}

TEST(Bridge, PitsDeeperThanTheOverhangStayOpen) {
  // Depth of a pit of three balls of radius 2, 2 apart: 2 - sqrt(4 - 4/3).
  const double depth = 2 - std::sqrt(4 - 4.0 / 3);
  EXPECT_TRUE(compiled(sheet(0.95 * depth, true)).objects[0].tree.bridges.all.empty());
  const Scene scene = compiled(sheet(1.05 * depth, true));
  const Bridges& bridges = scene.objects[0].tree.bridges;
  ASSERT_FALSE(bridges.all.empty());
  EXPECT_NEAR(bridges.deepest, depth, 1e-4);
}

TEST(Bridge, NearestPointIsThatOfTheHull) {
  // Against the hull sampled by the balls in it: |p - c| - r over weights of the three leaves.
  Random random(3);
  int facets = 0, cones = 0;
  SceneDescription d = sheet(0.5, true);
  for (Sphere& s : d.objects[0].tree.cover) s.x *= 1.02f;  // a little irregular
  encloseDescendants(d.objects[0].tree);
  countLevels(d.objects[0].tree);
  d.objects[0].tree.statistics.back().overhang_bound = 0.6f;
  const Scene scene = compiled(d);
  const CompiledTree& tree = scene.objects[0].tree;
  ASSERT_GT(tree.bridges.all.size(), 100u);
  for (int n = 0; n < 8000; ++n) {
    const Bridge& bridge = tree.bridges.all[random.below(static_cast<std::uint32_t>(tree.bridges.all.size()))];
    const Eigen::Vector3d p = bridge.a + test::randomPoint(random, 3);
    BridgeContact contact;
    if (!nearestOnBridge(bridge, p, contact)) continue;
    ++(bridge.isPair() ? cones : facets);
    const auto leaf = [&](std::size_t k) { return tree.cover_records[bridge.slot[k]]; };
    double gap = 1e9;
    constexpr int kSteps = 60;
    for (int i = 0; i <= kSteps; ++i)
      for (int j = 0; i + j <= kSteps; ++j) {
        const double b = i / double(kSteps), c = j / double(kSteps), a = 1 - b - c;
        const Eigen::Vector3d centre = a * Eigen::Vector3d(leaf(0).x, leaf(0).y, leaf(0).z) +
                                       b * Eigen::Vector3d(leaf(1).x, leaf(1).y, leaf(1).z) +
                                       c * Eigen::Vector3d(leaf(2).x, leaf(2).y, leaf(2).z);
        gap = std::min(gap, (p - centre).norm() - (a * double(leaf(0).radius) + b * double(leaf(1).radius) + c * double(leaf(2).radius)));
      }
    if (contact.gap < -1.5) continue;  // close to the plane of the centres either facet is near
    EXPECT_NEAR(contact.gap, gap, 2e-3);
    EXPECT_NEAR(contact.normal.norm(), 1, 1e-9);
    EXPECT_TRUE(mayTouchBridge(bridge, p, contact.gap + 1e-9, 1e-3));
  }
  EXPECT_GT(facets, 50);
  EXPECT_GT(cones, 50);
}

}  // namespace
}  // namespace spheretree::runtime
