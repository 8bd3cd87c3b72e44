// SPDX-License-Identifier: Apache-2.0
#include "spheretree/runtime/bridge.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>

#include "kernel.h"
#include "spheretree/runtime/contact.h"
#include "spheretree/runtime/step.h"
#include "support/shape_trees.h"

namespace spheretree::runtime {
namespace {

using test::Random;

const Quaternion kUpright(1, 0, 0, 0);

Eigen::Vector3d vector(const float* v) { return {v[0], v[1], v[2]}; }

/// A sheet of equal balls in hexagonal order, 2 apart.
std::vector<Sphere> sheetOfBalls() {
  std::vector<Sphere> balls;
  for (int row = 0; row < 14; ++row)
    for (int i = 0; i < 12; ++i) balls.push_back(test::ball(2 * i + row % 2 - 12, std::sqrt(3.0) * row - 12, 0, 2));
  return balls;
}

SceneDescription sceneOf(SphereTree tool, std::vector<Sphere> balls, double stated, bool bridges = true) {
  SceneDescription d;
  d.tool = std::move(tool);
  d.objects.push_back({test::stating(test::treeOfBalls(std::move(balls)), stated), {}});
  d.bridges = bridges;
  return d;
}
SceneDescription sheet(double stated, bool bridges = true) { return sceneOf(test::oneBallTree(1), sheetOfBalls(), stated, bridges); }

/// A ball of balls, each a little off its place.
SceneDescription roughBall(std::uint64_t seed) {
  Random random(seed);
  std::vector<Sphere> balls;
  constexpr int kCount = 300;
  for (int i = 0; i < kCount; ++i) {
    const double z = 1 - (2 * i + 1.0) / kCount, rim = std::sqrt(1 - z * z), angle = 2.399963229728653 * i, far = random.between(5.8, 6.2);
    balls.push_back(test::ball(far * rim * std::cos(angle), far * rim * std::sin(angle), far * z, random.between(1.1, 1.3)));
  }
  SceneDescription d = sceneOf(test::rodTree(12, 20, 0.7), balls, 0.35);
  d.objects[0].pose = {{1, 2, -3}, rotationOf({0.3, -0.7, 1.1})};
  return d;
}

Scene compiled(const SceneDescription& d) {
  Scene scene;
  std::string fault;
  EXPECT_TRUE(compileScene(d, scene, fault)) << fault;
  return scene;
}

std::vector<Bridge> all(const Scene& scene) {
  std::vector<Bridge> out;
  for (const CompiledBridges& b : scene.bridges)
    for (const Bridge& bridge : b.tree.of_slot)
      if (bridge.radius > 0) out.push_back(bridge);
  return out;
}

/// The leaves of a bridge: centres and radii.
std::vector<std::pair<Eigen::Vector3d, double>> leavesOf(const Bridge& b) {
  const Eigen::Vector3d a = vector(b.a), axis = vector(b.axis);
  const double r = static_cast<double>(b.radius), rise = static_cast<double>(b.v_extra), slope = static_cast<double>(b.u_extra) * rise;
  if (b.isCone()) return {{a, r}, {a + axis * static_cast<double>(b.length), r - slope * static_cast<double>(b.length)}};
  // Points of the plane of centres where the weights are 1 and 0: the normal carries no weight.
  Eigen::Matrix3d rows;
  rows << vector(b.u).transpose(), vector(b.v).transpose(), axis.transpose();
  const auto at = [&](double u, double v, double more) -> Eigen::Vector3d { return a + rows.inverse() * Eigen::Vector3d(u, v, -more); };
  const double du = static_cast<double>(b.u_extra), dv = static_cast<double>(b.v_extra);
  return {{a, r}, {at(1, 0, du), r + du}, {at(0, 1, dv), r + dv}};
}

/// Gap of a ball and the bridge where the nearest point of the bridge lies between its leaves; by the formulas of bridge.h in double,
/// `slack` beyond the edges. NaN elsewhere.
double gapAt(const Bridge& b, const Eigen::Vector3d& p, double radius, double slack) {
  const Eigen::Vector3d t = p - vector(b.a), axis = vector(b.axis);
  const double u = vector(b.u).dot(t), v = vector(b.v).dot(t), along = axis.dot(t), u_extra = static_cast<double>(b.u_extra),
               v_extra = static_cast<double>(b.v_extra), length = static_cast<double>(b.length), r = static_cast<double>(b.radius);
  if (b.isCone()) {
    const double off = (t - along * axis).norm(), foot = along - off * u_extra;
    if (u > slack || v > slack || foot < -slack * length || foot > (1 + slack) * length || off < 1e-3 * length) return NAN;
    return along * u_extra * v_extra + off * v_extra - r - radius;
  }
  if (u < -slack || v < -slack || u + v > 1 + slack || along + u * u_extra + v * v_extra < 1e-3) return NAN;
  return along - r - radius;
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
  const double bumps = ripple(compiled(sheet(0.5, false)), penetration), flat = ripple(compiled(sheet(0.5)), penetration);
  EXPECT_GT(bumps, 0.1);
  EXPECT_LT(flat, 1e-3);
  EXPECT_LE(penetration, kGapTolerance);
}

TEST(Bridge, ABallThatLiesLowIsPassedOver) {
  std::vector<Sphere> balls = sheetOfBalls();
  for (Sphere& s : balls)
    if (std::abs(s.x) < 1.1f && std::abs(s.y) < 1.1f) s.z -= 0.15f;
  double penetration = 0;
  const double bumps = ripple(compiled(sceneOf(test::oneBallTree(1), balls, 0.7, false)), penetration);
  EXPECT_GT(bumps, 0.15);
  EXPECT_LT(ripple(compiled(sceneOf(test::oneBallTree(1), balls, 0.7)), penetration), 1e-3);
  EXPECT_LE(penetration, kGapTolerance);
}

TEST(Bridge, LeavesOfUnevenHeightBecomeFlat) {
  // Most lie low, so that those on top are apart from each other.
  Random random(5);
  std::vector<Sphere> balls = sheetOfBalls();
  for (Sphere& s : balls) s.z -= static_cast<float>(random.between(0, 0.3));
  double penetration = 0;
  EXPECT_GT(ripple(compiled(sceneOf(test::oneBallTree(1), balls, 1, false)), penetration), 0.3);
  EXPECT_LT(ripple(compiled(sceneOf(test::oneBallTree(1), balls, 1)), penetration), 0.03);
}

TEST(Bridge, FarBelowAFlatFaceNothingLeaps) {
  // Tops differ by some hundredths of the overhang: a hull over them has folds, and the nearest point leaps over these by the depth times
  // their angle. Over a flat face the force changes by no more than the hand moves.
  Random random(8);
  std::vector<Sphere> balls = sheetOfBalls();
  for (Sphere& s : balls) s.z -= static_cast<float>(random.between(0, 0.04));
  const Scene scene = compiled(sceneOf(test::oneBallTree(1), balls, 1));
  Workspace workspace(scene);
  for (double y = -6; y <= 6; y += 2) {
    StepResult last;
    reset(workspace);
    for (double z = 5; z > -100; z -= 0.1) last = step(scene, {{-7, y, z}, {1, 0, 0, 0}}, Mode::Constrained, workspace);
    EXPECT_GT(last.wrench.force.z(), 100);
    for (double x = -7; x < 7; x += 0.05) {
      const StepResult r = step(scene, {{x, y, -100}, {1, 0, 0, 0}}, Mode::Constrained, workspace);
      EXPECT_LE((r.wrench.force - last.wrench.force).norm(), 1.01 * 0.05) << x << ' ' << y;
      last = r;
    }
  }
}

TEST(Bridge, LeavesThatStandOutFarArePassedOver) {
  // Outside the region of work leaves stand out by more than a bridge may: the probe comes down to the others all the same.
  Random random(6);
  std::vector<Sphere> balls = sheetOfBalls();
  for (Sphere& s : balls)
    s.z += static_cast<float>(std::abs(s.x) > 9 || std::abs(s.y) > 9 ? random.between(2, 4) : random.between(-0.3, 0));
  SceneDescription d = sceneOf(test::oneBallTree(1), balls, 5);
  d.objects[0].tree.provenance.work_overhang_mm = 1;
  double penetration = 0;
  EXPECT_LT(ripple(compiled(d), penetration), 0.03);
}

TEST(Bridge, NoneLeansOnARimThatStandsOutALittle) {
  // A work that is flat, with an overhang as deep as its pits; leaves round it stand out by a fifth more. No hull rests on these.
  const double depth = 2 - std::sqrt(4 - 4.0 / 3);
  std::vector<Sphere> balls = sheetOfBalls();
  for (Sphere& s : balls) s.z += static_cast<float>(std::abs(s.x) > 9 || std::abs(s.y) > 9 ? 0.2 * depth : 0);
  SceneDescription d = sceneOf(test::oneBallTree(1), balls, 1);
  d.objects[0].tree.provenance.work_overhang_mm = static_cast<float>(1.001 * depth);
  const Scene scene = compiled(d);
  Workspace workspace(scene);
  StepResult r;
  for (double z = 5; z > 2; z -= 0.05) r = step(scene, {{-4, 0.3, z}, {1, 0, 0, 0}}, Mode::Constrained, workspace);
  for (double x = -4; x < 4; x += 0.05) {
    r = step(scene, {{x, 0.3, 2}, {1, 0, 0, 0}}, Mode::Constrained, workspace);
    EXPECT_NEAR(r.graphic.position.z(), 3, 1e-3) << x;
  }
}

TEST(Bridge, PitsDeeperThanTheOverhangStayOpen) {
  const double depth = 2 - std::sqrt(4 - 4.0 / 3);  // of a pit of three balls of radius 2, 2 apart
  EXPECT_TRUE(compiled(sheet(0.98 * depth / kDeepestPit)).bridges.empty());
  EXPECT_GT(all(compiled(sheet(1.02 * depth / kDeepestPit))).size(), 400u);
  EXPECT_TRUE(compiled(sheet(1.02 * depth, false)).bridges.empty());
}

TEST(Bridge, WhereATreeHasWorkItsOverhangThereCounts) {
  SceneDescription d = sheet(5);
  EXPECT_FALSE(compiled(d).bridges.empty());
  const double depth = 2 - std::sqrt(4 - 4.0 / 3);
  d.objects[0].tree.provenance.work_overhang_mm = static_cast<float>(0.98 * depth / kDeepestPit);
  EXPECT_TRUE(compiled(d).bridges.empty());
}

/// Two facets side by side that lean away from each other by half a degree. Their corners are so far apart that the pits between two alone
/// would be too deep, were it not for the leaves below.
std::vector<Sphere> twoWideFacets() {
  return {test::ball(0, -5.95, 0, 6.4),    test::ball(0, 5.95, 0, 6.4),    test::ball(9.5, 0, -0.05, 6.4),
          test::ball(-9.5, 0, -0.05, 6.4), test::ball(3.1, 0, -0.15, 6.4), test::ball(-3.1, 0, -0.15, 6.4)};
}

TEST(Bridge, NoSlitIsLeftAlongAWideSide) {
  const Scene scene = compiled(sceneOf(test::oneBallTree(5), twoWideFacets(), 1.43));
  for (double x = -0.1; x <= 0.1; x += 0.004) {
    Workspace workspace(scene);
    StepResult r;
    for (double z = 12; z > 11; z -= 0.02) r = step(scene, {{x, 0, z}, {1, 0, 0, 0}}, Mode::Constrained, workspace);
    EXPECT_NEAR(r.graphic.position.z(), 11.4, 0.01) << x;
  }
}

// No cone closes the outer sides of the two: there a facet hangs free, 1.1 above the leaf below.
TEST(Bridge, ABallThatComesInBelowARimStaysBelow) {
  const Scene scene = compiled(sceneOf(test::oneBallTree(0.5), twoWideFacets(), 1.43)),
              bare = compiled(sceneOf(test::oneBallTree(0.5), twoWideFacets(), 1.43, false));
  const Eigen::Vector3d rim(4.75, -2.975, 0), in = Eigen::Vector3d(-5.95, 9.5, 0).normalized();
  const auto at = [&](double inwards, double z) -> Configuration { return {rim + inwards * in + Eigen::Vector3d(0, 0, z), kUpright}; };
  Workspace workspace(scene), bare_workspace(bare);
  StepResult r;
  for (double z = 9; z > 6.5; z -= 0.02) r = step(scene, at(0.5, z), Mode::Constrained, workspace);
  EXPECT_NEAR(r.graphic.position.z(), 6.88, 0.01);  // it came from above

  reset(workspace);
  double deepest = 0;
  for (double inwards = -4; inwards < 1; inwards += 0.01) {
    r = step(scene, at(inwards, 5.3), Mode::Constrained, workspace);
    const StepResult of_bare = step(bare, at(inwards, 5.3), Mode::Constrained, bare_workspace);
    EXPECT_LT((r.graphic.position - of_bare.graphic.position).norm(), 1e-4) << inwards;
    if (in.dot(r.graphic.position - rim) > 0) deepest = std::max(deepest, 6.88 - r.graphic.position.z());
  }
  EXPECT_GT(deepest, 0.5);
}

// In a round hole with leaves of several sizes a facet could lie across: it would touch its leaves where others hide them.
TEST(Bridge, FacetsTouchWhatShows) {
  Random random(5);
  std::vector<Sphere> balls;
  constexpr double kStated = 0.3;
  for (int row = 0; row < 16; ++row)
    for (int i = 0; i < 20; ++i) {
      const double r = random.between(0.5, 1.6), angle = 2 * M_PI * (i + 0.5 * (row % 2)) / 20, far = 2 + r - random.between(0, 0.3);
      balls.push_back(test::ball(far * std::cos(angle), far * std::sin(angle), 0.5 * row, r));
    }
  const Scene scene = compiled(sceneOf(test::oneBallTree(1), balls, kStated));
  const CompiledTree& tree = scene.objects[0].tree;
  std::size_t facets = 0;
  for (const Bridge& b : all(scene)) {
    if (b.isCone()) continue;
    ++facets;
    for (const auto& [centre, radius] : leavesOf(b)) {
      const Eigen::Vector3d touch = centre + radius * vector(b.axis);
      for (std::size_t slot = 0; slot < tree.node.size(); ++slot) {
        if (tree.node[slot] == kNoNode) continue;
        const Sphere& s = tree.spheres[slot];
        EXPECT_LT(static_cast<double>(s.radius) - (touch - Eigen::Vector3d(s.x, s.y, s.z)).norm(), kDeepestPit * kStated / 3);
      }
    }
  }
  EXPECT_GT(facets, 100u);
}

TEST(Bridge, NothingStandsOutFartherThanStated) {
  for (const std::uint64_t seed : {1u, 2u}) {
    SceneDescription d = roughBall(seed);
    const double stated = static_cast<double>(d.objects[0].tree.statistics.back().overhang_bound);
    const Scene scene = compiled(d);
    const CompiledTree& tree = scene.objects[0].tree;
    double highest = 0;
    const auto look = [&](const Eigen::Vector3d& p) {
      double nearest = 1e9;
      for (std::size_t slot = 0; slot < tree.node.size(); ++slot)
        if (tree.node[slot] != kNoNode) {
          const Sphere& s = tree.spheres[slot];
          nearest = std::min(nearest, (p - Eigen::Vector3d(s.x, s.y, s.z)).norm() - static_cast<double>(s.radius));
        }
      highest = std::max(highest, nearest);
    };
    std::size_t facets = 0, cones = 0;
    for (const Bridge& b : all(scene)) {
      const auto leaves = leavesOf(b);
      if (b.isCone()) {
        ++cones;
        const Eigen::Vector3d axis = vector(b.axis), e1 = axis.unitOrthogonal(), e2 = axis.cross(e1);
        const double rise = static_cast<double>(b.v_extra), slope = static_cast<double>(b.u_extra) * rise;
        for (double angle = 0; angle < 6.28; angle += 0.1) {
          const Eigen::Vector3d out = std::cos(angle) * e1 + std::sin(angle) * e2;
          if (vector(b.u).dot(out) > 0 || vector(b.v).dot(out) > 0) continue;
          const Eigen::Vector3d normal = slope * axis + rise * out;
          for (double w = 0; w <= 1; w += 0.1)
            look((1 - w) * (leaves[0].first + leaves[0].second * normal) + w * (leaves[1].first + leaves[1].second * normal));
        }
      } else {
        ++facets;
        for (int i = 0; i <= 8; ++i)
          for (int j = 0; i + j <= 8; ++j) {
            Eigen::Vector3d p = Eigen::Vector3d::Zero();
            const std::array<double, 3> w{(8 - i - j) / 8.0, i / 8.0, j / 8.0};
            for (std::size_t k = 0; k < 3; ++k) p += w[k] * (leaves[k].first + leaves[k].second * vector(b.axis));
            look(p);
          }
      }
    }
    EXPECT_GT(facets, 300u);
    EXPECT_GT(cones, 200u);
    EXPECT_LE(highest, kDeepestPit * stated);
    EXPECT_GT(highest, 0.5 * stated);
  }
}

TEST(Bridge, RowsAreThoseOfTheHull) {
  // Against the hull of two or three leaves, sampled by the balls in it: |p - c| - r over weights of the leaves.
  Random random(3);
  int facets = 0, cones = 0;
  SceneDescription d = roughBall(3);
  d.tool = test::oneBallTree(0.5);
  d.objects[0].pose = {};
  const Scene scene = compiled(d);
  const Eigen::Vector3d anchor = scene.objects[0].anchor;
  Workspace workspace(scene);
  for (int n = 0; n < 600; ++n) {
    const Configuration pose{anchor + test::randomPoint(random, 1).normalized() * random.between(7.5, 8.1), test::randomRotation(random)};
    const PairSet none = findPairs(scene, pose, 0, false, 0, workspace);
    const PairSet near = findNearBridges(scene, pose, 0.3, 1u << 30, workspace);
    RowSet rows = makeRows(scene, PairSet{{}, none.runs}, pose, RowForm::TrueDistance, Eigen::Matrix3d::Identity(), workspace);
    addBridgeRows(scene, near, pose, 0.3, rows, workspace);
    ASSERT_EQ(rows.rows.count, near.pairs.size());
    for (std::uint32_t i = 0; i < rows.rows.count; ++i) {
      if (rows.rows.b[i] < -1e29f) continue;
      const Bridge& bridge = scene.bridges[0].tree.of_slot[near.pairs[i] & 0xffff];
      if (!std::isfinite(gapAt(bridge, pose.position - anchor, 0.5, 2e-4))) continue;  // beside a facet: the row is that of its plane
      const auto leaves = leavesOf(bridge);
      ++(bridge.isCone() ? cones : facets);
      const double gap = -static_cast<double>(rows.rows.b[i] / rows.weight[i]);
      EXPECT_GE(gap, -1.001 * static_cast<double>(kDeepestDip));
      double least = 1e9;
      constexpr int kSteps = 40;
      for (int k = 0; k <= kSteps; ++k)
        for (int j = 0; j + k <= (leaves.size() == 2 ? k : kSteps); ++j) {
          const std::array<double, 3> w{1 - (k + j) / double(kSteps), k / double(kSteps), j / double(kSteps)};
          Eigen::Vector3d c = Eigen::Vector3d::Zero();
          double r = 0.5;
          for (std::size_t l = 0; l < leaves.size(); ++l) {
            c += w[l] * leaves[l].first;
            r += w[l] * leaves[l].second;
          }
          least = std::min(least, (pose.position - anchor - c).norm() - r);
        }
      EXPECT_NEAR(gap, least, 3e-3) << (bridge.isCone() ? "cone" : "facet");
      // The row is the derivative of the gap: the normal, as the reference point is the centre.
      const Eigen::Vector3d normal(rows.rows.a[0][i], rows.rows.a[1][i], rows.rows.a[2][i]);
      EXPECT_NEAR(normal.norm(), 1, 1e-5);
      const Eigen::Vector3d move = test::randomPoint(random, 1e-3), p = pose.position - anchor;
      const double before = gapAt(bridge, p, 0.5, 0.01), after = gapAt(bridge, p + move, 0.5, 0.01);
      if (std::isfinite(before) && std::isfinite(after)) {
        EXPECT_NEAR(after - before, normal.dot(move), 5e-6);
      }
    }
  }
  EXPECT_GT(facets, 200);
  EXPECT_GT(cones, 100);
}

TEST(Bridge, NoneIsMissedWithinTheMargin) {
  // Every bridge against every leaf of the tool, at the pose of the search and at poses within the margin of it.
  const SceneDescription d = roughBall(4);
  const Scene scene = compiled(d);
  Workspace workspace(scene);
  Random random(5);
  std::size_t touching = 0, listed = 0;
  for (int n = 0; n < 300; ++n) {
    const Eigen::Vector3d out = test::randomPoint(random, 1).normalized();
    const Quaternion q = test::randomRotation(random);
    const Configuration pose{d.objects[0].pose.position + 7.6 * out - q * Eigen::Vector3d(0, 0, random.between(0, 12)), q};
    const double margin = std::array{0.01, 0.1, 0.5}[static_cast<std::size_t>(n) % 3];
    const PairSet near = findNearBridges(scene, pose, margin, 1u << 30, workspace);
    ASSERT_FALSE(near.coarse);
    const std::set<std::uint32_t> found(near.pairs.begin(), near.pairs.end());
    ASSERT_EQ(found.size(), near.pairs.size());
    listed += found.size();
    for (int m = 0; m < 3; ++m) {
      Displacement way{test::randomPoint(random, 1), test::randomPoint(random, 0.1)};
      const double reach = way.translation.norm() + scene.tool.reach * way.rotation.norm(), part = m == 0 ? 0 : margin / reach;
      const Configuration there = moved(pose, {part * way.translation, part * way.rotation});
      for (std::size_t tool = 0; tool < scene.tool.node.size(); ++tool) {
        if (scene.tool.node[tool] == kNoNode) continue;
        const Sphere& s = scene.tool.spheres[tool];
        const Eigen::Vector3d p = there.position + there.orientation * Eigen::Vector3d(s.x, s.y, s.z) - scene.objects[0].anchor;
        for (std::size_t slot = 0; slot < scene.bridges[0].tree.of_slot.size(); ++slot) {
          const Bridge& b = scene.bridges[0].tree.of_slot[slot];
          if (!(b.radius > 0)) continue;
          const double gap = gapAt(b, p, static_cast<double>(s.radius), 0);
          if (!(gap <= (m == 0 ? margin : 0)) || gap < -static_cast<double>(kDeepestDip)) continue;
          ++touching;
          EXPECT_TRUE(found.contains(static_cast<std::uint32_t>(tool << 16 | slot))) << n << ' ' << m << " gap " << gap;
        }
      }
    }
  }
  EXPECT_GT(touching, 500u);
  EXPECT_LT(listed, 20 * touching);  // and not simply all of them
}

TEST(Bridge, WhatIsKeptOfOneListLeavesTheNextAlone) {
  // The lists of several objects stand one behind the other, and are thinned in place.
  const Scene scene = compiled(roughBall(4));
  const BridgeTree& tree = scene.bridges[0].tree;
  std::vector<std::uint32_t> slots;
  for (std::uint32_t slot = 0; slot < tree.of_slot.size(); ++slot)
    if (tree.of_slot[slot].radius > 0) slots.push_back(slot);
  BridgeRequest request{};
  for (int k = 0; k < 3; ++k) request.rotation[4 * k] = 1;
  request.tool = scene.tool.spheres.data();
  request.bridges = tree.of_slot.data();
  request.most_gap = 1e6f;  // all are kept, as far as their place lets them
  for (const Kernel kernel : {Kernel::Scalar, Kernel::Best}) {
    const Workspace workspace(scene, kernel);
    for (std::uint32_t count = 1; count <= 20; ++count) {
      std::vector<std::uint32_t> pairs(count + 32, 0xffffffffu);
      for (std::uint32_t i = 0; i < count; ++i) pairs[i] = slots[i];
      request.pairs = pairs.data();
      request.count = count;
      EXPECT_EQ(workspace.kernel->nearBridges(request, pairs.data()), count);
      EXPECT_TRUE(std::all_of(pairs.begin() + count, pairs.end(), [](std::uint32_t pair) { return pair == 0xffffffffu; })) << count;
    }
  }
}

TEST(Bridge, AnObjectThatIsTurnedHasTheSameBridges) {
  SceneDescription d = sheet(1.1);  // leaves in order: many choices are ties
  const std::vector<Bridge> as_filed = all(compiled(d));
  const Quaternion turn = rotationOf({0.4, -0.9, 0.7});
  d.objects[0].pose.orientation = turn;
  const std::vector<Bridge> turned = all(compiled(d));
  ASSERT_EQ(turned.size(), as_filed.size());
  const auto places = [](const std::vector<Bridge>& bridges, const Quaternion& back) {
    std::multiset<std::array<long, 4>> out;  // to 0.01 mm: nothing of the sheet lies on the border between two
    for (const Bridge& b : bridges) {
      const Eigen::Vector3d a = 100 * (back * vector(b.a)) + Eigen::Vector3d(0.31, 0.27, 0.33);
      out.insert({std::lround(a.x()), std::lround(a.y()), std::lround(a.z()), b.isCone()});
    }
    return out;
  };
  EXPECT_EQ(places(turned, turn.conjugate()), places(as_filed, kUpright));
}

TEST(Bridge, TheToolRestsOnWhatItTouches) {
  // A ball pressed onto the rough ball: something is there where it is held, not only the plane of a facet beside it.
  SceneDescription d = roughBall(10);
  constexpr double kRadius = 0.7;
  d.tool = test::oneBallTree(kRadius);
  const Scene scene = compiled(d);
  const Eigen::Vector3d anchor = scene.objects[0].anchor;
  const std::vector<Bridge> bridges = all(scene);
  Random random(11);
  int held = 0, bridged = 0;
  for (int spot = 0; spot < 400; ++spot) {
    Workspace workspace(scene);
    const Eigen::Vector3d out = test::randomPoint(random, 1).normalized(), way = test::randomPoint(random, 0.01);
    for (int n = 0; n < 30; ++n) {  // not so deep that the nearest point jumps
      const StepResult r = step(scene, {anchor + (8.5 - 0.03 * n) * out + n * way, kUpright}, Mode::Constrained, workspace);
      if (r.active == 0) continue;
      const Eigen::Vector3d p = r.graphic.position - anchor;
      double leaf_gap = 1e9, bridge_gap = 1e9;
      for (std::size_t slot = 0; slot < scene.objects[0].tree.node.size(); ++slot)
        if (scene.objects[0].tree.node[slot] != kNoNode) {
          const Sphere& s = scene.objects[0].tree.spheres[slot];
          leaf_gap = std::min(leaf_gap, (p - Eigen::Vector3d(s.x, s.y, s.z)).norm() - static_cast<double>(s.radius) - kRadius);
        }
      for (const Bridge& b : bridges) bridge_gap = std::min(bridge_gap, gapAt(b, p, kRadius, 1e-3));
      EXPECT_LT(std::min(leaf_gap, bridge_gap), 1e-4) << spot << ' ' << n;
      ++held;
      bridged += bridge_gap < leaf_gap;
    }
  }
  EXPECT_GT(held, 3000);
  EXPECT_GT(bridged, 1000);
}

TEST(Bridge, KernelsGiveTheSameBits) {
  const Scene scene = compiled(roughBall(6));
  Workspace scalar(scene, Kernel::Scalar), best(scene, Kernel::Best);
  Random random(7);
  std::uint32_t rows_seen = 0;
  for (int n = 0; n < 100; ++n) {
    const Configuration pose{scene.objects[0].anchor + test::randomPoint(random, 8), test::randomRotation(random)};
    std::array<RowSet, 2> rows;
    std::array<PairSet, 2> near;
    for (std::size_t k = 0; k < 2; ++k) {
      Workspace& workspace = k == 0 ? scalar : best;
      const PairSet pairs = findPairs(scene, pose, 0.2, false, 1u << 30, workspace);
      near[k] = findNearBridges(scene, pose, 0.2, 1u << 30, workspace);
      rows[k] = makeRows(scene, pairs, pose, RowForm::TrueDistance, Eigen::Matrix3d::Identity(), workspace);
      addBridgeRows(scene, near[k], pose, 0.2, rows[k], workspace);
    }
    ASSERT_TRUE(std::equal(near[0].pairs.begin(), near[0].pairs.end(), near[1].pairs.begin(), near[1].pairs.end()));
    ASSERT_EQ(rows[0].rows.count, rows[1].rows.count);
    rows_seen += rows[0].rows.count;
    for (std::uint32_t i = 0; i < rows[0].rows.count; ++i) {
      for (std::size_t k = 0; k < 6; ++k) ASSERT_EQ(rows[0].rows.a[k][i], rows[1].rows.a[k][i]);
      ASSERT_EQ(rows[0].rows.b[i], rows[1].rows.b[i]);
      ASSERT_EQ(rows[0].weight[i], rows[1].weight[i]);
    }
  }
  EXPECT_GT(rows_seen, 1000u);
}

TEST(Bridge, LeavesComeFirstWhereBothCannotBe) {
  // A ball in a pit between two sheets, with room between the leaves and none between the bridges.
  std::vector<Sphere> balls = sheetOfBalls();
  const double pit = 2 - std::sqrt(4 - 4.0 / 3), apart = 2 * (2 + 1) - 1.2 * pit;
  for (const Sphere& s : sheetOfBalls()) balls.push_back(test::ball(s.x, s.y, apart, 2));
  const Eigen::Vector3d middle(0 - 12 + 12, std::sqrt(3.0) * 6 - 12 + 2 / std::sqrt(3.0) - 2 / std::sqrt(3.0), 0.5 * apart);
  const Eigen::Vector3d hole = middle + Eigen::Vector3d(1, 1 / std::sqrt(3.0), 0);
  const SceneDescription d = sceneOf(test::oneBallTree(1), balls, 0.5);
  const Scene scene = compiled(d);
  Workspace workspace(scene);
  resetTo({hole, {1, 0, 0, 0}}, workspace);
  std::uint32_t faults = 0;
  double penetration = 0;
  for (int n = 0; n < 400; ++n) {
    const Configuration haptic{hole + Eigen::Vector3d(0.3 * std::sin(0.05 * n), 0.2 * std::cos(0.03 * n), 0.5 * std::sin(0.02 * n)),
                               {1, 0, 0, 0}};
    const StepResult r = step(scene, haptic, Mode::Constrained, workspace);
    faults |= r.faults;
    penetration = std::max(penetration, r.penetration);
    ASSERT_TRUE(isFinite(r.graphic));
  }
  EXPECT_LE(penetration, kGapTolerance);
  EXPECT_FALSE(faults & (kPenetrating | kRowsConflict));
}

TEST(Bridge, AFullListLosesComfortOnly) {
  SceneDescription d = roughBall(8);
  d.tool = test::boxTree({2, 2, 2}, {7, 7, 7}, 0.6);
  d.step_limits.max_pairs = 64;
  const Scene scene = compiled(d);
  Workspace workspace(scene);
  Random random(9);
  Configuration haptic{{1, 2, 9}, {1, 0, 0, 0}};
  double penetration = 0;
  for (int n = 0; n < 300; ++n) {
    haptic = moved(
        haptic, {test::randomPoint(random, 0.2) - 0.02 * (haptic.position - d.objects[0].pose.position), test::randomPoint(random, 0.02)});
    const StepResult r = step(scene, haptic, Mode::Constrained, workspace);
    penetration = std::max(penetration, r.penetration);
    ASSERT_TRUE(r.wrench.force.allFinite());
  }
  EXPECT_LE(penetration, kGapTolerance);
}

}  // namespace
}  // namespace spheretree::runtime
