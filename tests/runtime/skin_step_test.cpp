// SPDX-License-Identifier: Apache-2.0
// Steps of a tool on skins: its pose at rest, the smoothness of its path, and its largest depth. Subject: step.h
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "spheretree/runtime/step.h"
#include "support/rig.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using test::degreesBetween;
using test::kUpright;
using test::Random;
using test::Rig;
using test::withSkin;

TEST(SkinStep, ABallRestsOnTheSmoothSphere) {
  // The finest possible skin of this kind: positions are stored in steps of 1.5e-4 mm.
  Rig rig(test::oneBallTree(1), withSkin(test::oneBallTree(5.2), test::roundSkin(5)));
  Random random(1);
  for (int n = 0; n < 300; ++n) {
    const Vector3d way = random.direction();
    const double depth = random.between(0.05, 2.5);
    resetTo({6.5 * way, kUpright}, *rig.workspace);
    StepResult r;
    for (int k = 0; k < 60; ++k) r = rig.toPoint((6.5 - std::min(0.1 * k, 0.5 + depth)) * way);
    ASSERT_NEAR(r.graphic.position.norm(), 6, 3e-4) << way.transpose();
    ASSERT_LT(degreesBetween(r.wrench.force, way), 0.1) << way.transpose() << " at " << depth;
    ASSERT_NEAR(r.wrench.force.norm(), depth, 1e-3);
    ASSERT_EQ(r.faults, 0u);
  }
}

/// The largest second difference of the force and the largest angle to the true normal along a great circle, at this
/// `depth`.
/// below.
std::pair<double, double> ripple(Rig& rig, double touch, double depth, const Vector3d& from, const Vector3d& towards) {
  Vector3d last = Vector3d::Zero(), before = Vector3d::Zero();
  double jump = 0, angle = 0;
  resetTo({(touch + 0.5) * from, kUpright}, *rig.workspace);
  for (int n = 0; n < 3000; ++n) {
    const double a = 0.0005 * n;
    const Vector3d way = std::cos(a) * from + std::sin(a) * towards;
    const StepResult r = rig.toPoint((touch - std::min(depth, 0.02 * n - 0.5)) * way);
    if (n > 300) {
      jump = std::max(jump, (r.wrench.force - 2 * last + before).norm());
      angle = std::max(angle, degreesBetween(r.wrench.force, way));
    }
    before = last;
    last = r.wrench.force;
  }
  return {jump, angle};
}

TEST(SkinStep, ASphereIsFeltAsOne) {
  Random random(2);
  Rig skin(test::oneBallTree(1), withSkin(test::ellipsoidTree({5.1, 5.1, 5.1}, 500, 1), test::roundSkin(4)));
  for (int n = 0; n < 6; ++n) {
    const Vector3d from = random.direction(), towards = random.direction().cross(from).normalized();
    const auto [jump, angle] = ripple(skin, 6, n % 2 ? 1.5 : 0.5, from, towards);
    EXPECT_LT(jump, 2e-3) << n;
    EXPECT_LT(angle, 0.15) << n;
  }
  // The leaves of the same tree ripple, which shows that the measure detects it.
  skin.description.contact = ContactSurface::Leaves;
  std::string fault;
  ASSERT_TRUE(compileScene(skin.description, skin.scene, fault));
  skin.workspace = std::make_unique<Workspace>(skin.scene);
  const auto [jump, angle] = ripple(skin, 6.1, 0.5, Vector3d::UnitX(), Vector3d::UnitY());
  EXPECT_GT(angle, 2);
  EXPECT_GT(jump, 2e-3);
}

TEST(SkinStep, TrianglesInAPlaneMakeNoRipple) {
  for (const int n : {1, 7, 40}) {
    Rig rig(test::oneBallTree(0.7), withSkin(test::boxTree({4, 4, 0.2}, {16, 16, 1}, 0.9), test::gridSkin(n)), {{-4, -4, 0}, kUpright});
    resetTo({{-3, -3, 3}, kUpright}, *rig.workspace);
    const auto heightAt = [](int k) { return std::max(3 - 0.05 * k, 0.9); };
    for (int k = 0; k < 1000; ++k) {
      const double t = 0.001 * k;
      const Vector3d hand(-3 + 6 * t, -3 + 5 * t + 0.5 * std::sin(20 * t), heightAt(k));
      const StepResult r = rig.toPoint(hand);
      if (k < 60) continue;
      ASSERT_NEAR(r.graphic.position.z(), 1.7, 2e-5) << n << ' ' << k;
      ASSERT_LT((r.wrench.force - Vector3d(0, 0, 0.8)).norm(), 1e-3) << n << ' ' << k;
      ASSERT_EQ(r.faults, 0u);
    }
  }
}

// Hollows that are narrower than the ball: where it is, other patches hold it at each place.
Skin hollowSkin(Random& random) {
  const double turn = random.between(0, 3);
  const auto height = [turn](double x, double y) {
    const double u = std::cos(turn) * x + std::sin(turn) * y, v = std::cos(turn) * y - std::sin(turn) * x;
    return 0.3 * std::cos(2.2 * u) + 0.25 * std::cos(2.7 * v);
  };
  const auto onSurface = [height](const Vector3d& p) { return Vector3d(p.x(), p.y(), height(p.x(), p.y())); };
  constexpr int kSide = 24;
  test::SmoothMesh mesh;
  mesh.project = onSurface;
  const auto at = [](int i, int j) { return static_cast<std::uint16_t>(i * (kSide + 1) + j); };
  for (int i = 0; i <= kSide; ++i)
    for (int j = 0; j <= kSide; ++j) {
      const double x = 0.5 * i - 6 + random.between(-0.15, 0.15), y = 0.5 * j - 6 + random.between(-0.15, 0.15), d = 1e-5;
      mesh.positions.push_back(onSurface({x, y, 0}));
      mesh.normals.push_back(
          Vector3d((height(x - d, y) - height(x + d, y)) / (2 * d), (height(x, y - d) - height(x, y + d)) / (2 * d), 1).normalized());
    }
  for (int i = 0; i < kSide; ++i)
    for (int j = 0; j < kSide; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return test::skinOf(mesh);
}

TEST(SkinStep, ABallComesToRestInHollowsThatAreNarrowerThanItself) {
  Random random(3);
  for (int surface = 0; surface < 40; ++surface) {
    Rig rig(test::oneBallTree(1.2), withSkin(test::boxTree({6, 6, 0.5}, {24, 24, 2}, 0.9), hollowSkin(random)));
    for (int place = 0; place < 25; ++place) {
      const Vector3d over(random.between(-3, 3), random.between(-3, 3), 2.5);
      resetTo({over, kUpright}, *rig.workspace);
      for (int k = 0; k < 100; ++k) rig.toPoint(over - Vector3d(0, 0, 0.02 * std::min(k, 80)));
      Vector3d last = rig.toPoint(over - Vector3d(0, 0, 1.6)).graphic.position;
      double moves = 0;
      for (int k = 0; k < 60; ++k) {
        const Vector3d next = rig.toPoint(over - Vector3d(0, 0, 1.6)).graphic.position;
        if (k >= 40) moves = std::max(moves, (next - last).norm());
        last = next;
      }
      EXPECT_LT(moves, 2e-4) << "surface " << surface << ", over " << over.transpose();
    }
  }
}

TEST(SkinStep, SharpEdgesStaySharp) {
  // A ball around the edge of a box: the exact offset is a quarter of a cylinder.
  Rig rig(test::oneBallTree(1), withSkin(test::boxTree({2.5, 2.5, 2.5}, {6, 6, 6}, 0.8), test::boxSkin({3, 3, 3})));
  resetTo({{5, 0.3, 5}, kUpright}, *rig.workspace);
  rig.toPoint(Vector3d(3.5, 0.3, 3.5));
  for (int n = 0; n <= 300; ++n) {
    const double a = 0.005 * n;
    const Vector3d out(std::sin(a), 0, std::cos(a)), hand = Vector3d(3, 0.3 + 0.002 * n, 3) + 0.4 * out;
    StepResult r = rig.toPoint(hand);
    const Vector3d expected = hand + 0.6 * out;
    ASSERT_LT((r.graphic.position - expected).norm(), 2e-3) << n;
  }
}

TEST(SkinStep, ARidgeOfCurvedPatchesStaysSharp) {
  // Over the ridge the ball moves around an edge, although the patches on either side are curved.
  Rig rig(test::oneBallTree(0.5), withSkin(test::boxTree({2, 2, 1}, {8, 8, 3}, 1), test::ridgeSkin()));
  for (const double depth : {0.1, 0.3}) {
    resetTo({{-0.2, 0, 2}, kUpright}, *rig.workspace);
    for (int k = 0; k < 80; ++k) rig.toPoint(Vector3d(-0.2, 0, 2 - 0.02 * k));
    for (int n = -100; n <= 100; ++n) {
      const Vector3d hand(0.002 * n, 0.3, 0.5 - depth);
      const StepResult r = rig.toPoint(hand);
      if (std::abs(hand.x()) > 0.45 * hand.z()) continue;  // closer than this, the strips hold it
      const Vector3d edge(0, 0.3, 0), expected = edge + 0.5 * (hand - edge).normalized();
      EXPECT_LT((r.graphic.position - expected).norm(), 3e-3) << depth << " at " << hand.x();
      EXPECT_EQ(r.faults, 0u);
    }
  }
}

// Largest depth of a leaf of the tool in the guaranteed surface, every leaf against every triangle in double; and the
// distance by which the centre nearest to the origin is beyond the surface of cusps.
struct Depth {
  double triangles, outside;
};
class BruteForce {
 public:
  BruteForce(const SphereTree& tool, const Skin& skin) : tool_(test::leavesOf(tool)) {
    for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
      const SkinPatch patch = patchOf(skin, t);
      Triangle made{{}, Vector3d::Zero(), 0, static_cast<double>(allowanceOf(patch, skin.tolerance))};
      for (std::size_t k = 0; k < 3; ++k) {
        made.corner[k] = patch.position[k].cast<double>();
        made.middle += made.corner[k] / 3;
      }
      for (const Vector3d& p : made.corner) made.reach = std::max(made.reach, (p - made.middle).norm());
      triangles_.push_back(made);
    }
  }
  Depth at(const Configuration& pose) const {
    Depth depth{0, 1e9};
    for (const Sphere& leaf : tool_) {
      const Vector3d c = pose.orientation * Vector3d(leaf.x, leaf.y, leaf.z) + pose.position;
      depth.outside = std::min(depth.outside, c.norm() - test::cuspedRadius(c.normalized()));
      for (const Triangle& t : triangles_) {
        const double radius = std::max(static_cast<double>(leaf.radius) - t.allowance, 0.5 * static_cast<double>(leaf.radius));
        if ((c - t.middle).squaredNorm() > (t.reach + radius) * (t.reach + radius)) continue;
        depth.triangles = std::max(depth.triangles, radius - distanceTo(t, c));
      }
    }
    return depth;
  }

 private:
  struct Triangle {
    std::array<Vector3d, 3> corner;
    Vector3d middle;
    double reach, allowance;
  };
  static double distanceTo(const Triangle& t, const Vector3d& c) {
    const Vector3d up = (t.corner[1] - t.corner[0]).cross(t.corner[2] - t.corner[0]).normalized();
    bool over = true;
    double nearest = 1e9;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d from = c - t.corner[k], side = t.corner[(k + 1) % 3] - t.corner[k];
      over = over && up.cross(side).dot(from) >= 0;
      nearest = std::min(nearest, (from - std::clamp(from.dot(side) / side.squaredNorm(), 0.0, 1.0) * side).norm());
    }
    return over ? std::abs(up.dot(c - t.corner[0])) : nearest;
  }
  std::vector<Sphere> tool_;
  std::vector<Triangle> triangles_;
};

// A hand that wanders over cusps and pits at up to 2 m/s and 20 rad/s. Every leaf is measured from step `first` on.
void wander(bool is_ball, int first, int steps) {
  const Skin skin = test::cuspedSkin(4);
  const SphereTree tool = is_ball ? test::oneBallTree(0.8) : test::rodTree(12, 30, 0.4);
  Rig rig(tool, withSkin(test::ellipsoidTree({6.5, 6.5, 6.5}, 600, 1.5), skin));
  const BruteForce measure(tool, skin);
  Random random(is_ball ? 5 : 6);
  Configuration haptic{{0, 0, 12}, kUpright};
  Displacement velocity;
  int contacts = 0;
  for (int n = 0; n < first + steps; ++n) {
    velocity.translation = 0.9 * velocity.translation + test::randomPoint(random, 0.4) - 0.01 * haptic.position;
    velocity.rotation = 0.9 * velocity.rotation + test::randomPoint(random, 0.004);
    haptic = moved(haptic, velocity);
    const StepResult r = rig.to(haptic);
    ASSERT_FALSE(r.faults & (kPenetrating | kRowsConflict | kQpStopped | kPairsFull)) << "step " << n << " faults " << r.faults;
    contacts += r.active > 0;
    if (n < first) continue;
    const Depth depth = measure.at(r.graphic);
    ASSERT_LT(depth.triangles, kGapTolerance + 1e-4) << "step " << n;
    ASSERT_NEAR(depth.triangles, r.penetration, 1e-4) << "step " << n;
    ASSERT_GT(depth.outside, 0) << "step " << n;
  }
  EXPECT_GT(contacts, (first + steps) / 6);
}

TEST(SkinStep, NoLeafGetsDeepInRandomMotion) {
  const int steps = std::getenv("SPHERETREE_LONG") ? 500000 : 1500;  // together 10^6
  for (const bool is_ball : {true, false}) {
    SCOPED_TRACE(is_ball ? "ball" : "rod");
    wander(is_ball, 0, steps);
  }
}

// In step 48,658 of the rod the QP that aims at the sum of a series has no active rows. Its solution is then not the
// haptic pose.
TEST(SkinStep, AnExtrapolatedPieceEndsWhereItsRowsHold) { wander(false, 48640, 40); }

TEST(SkinStep, ATurnedAndMovedObjectIsFeltTheSame) {
  const Configuration there{{120, -40, 7}, rotationOf({0.9, -1.3, 0.5})};
  Rig here(test::rodTree(8, 16, 0.5), withSkin(test::oneBallTree(6.5), test::cuspedSkin(3))),
      elsewhere(test::rodTree(8, 16, 0.5), withSkin(test::oneBallTree(6.5), test::cuspedSkin(3)), there);
  for (int n = 0; n < 400; ++n) {
    const Configuration hand{{0.003 * n, 1, 8 - 0.01 * n}, rotationOf({0.002 * n, 0.001 * n, 0})};
    const StepResult a = here.to(hand), b = elsewhere.to(Configuration{there.position + there.orientation * hand.position,
                                                                       there.orientation * hand.orientation});
    ASSERT_LT((there.orientation * a.wrench.force - b.wrench.force).norm(), 5e-3) << n;
    ASSERT_LT((there.position + there.orientation * a.graphic.position - b.graphic.position).norm(), 5e-3) << n;
  }
}

TEST(SkinStep, LeavesAreFeltAsIfThereWereNoSkin) {
  SceneDescription with, without;
  with.tool = without.tool = test::rodTree(8, 16, 0.5);
  const SphereTree leaves = test::ellipsoidTree({6, 5, 7}, 300, 1);
  with.objects.push_back({test::withSkin(leaves, test::roundSkin(3)), {}});
  without.objects.push_back({leaves, {}});
  with.contact = ContactSurface::Leaves;
  Scene a, b;
  std::string fault;
  ASSERT_TRUE(compileScene(with, a, fault) && compileScene(without, b, fault)) << fault;
  Workspace wa(a), wb(b);
  Random random(7);
  Configuration hand{{0, 0, 9}, kUpright};
  for (int n = 0; n < 500; ++n) {
    hand = moved(hand, {test::randomPoint(random, 0.4) - 0.03 * hand.position, test::randomPoint(random, 0.02)});
    const StepResult x = step(a, hand, Mode::Constrained, wa), y = step(b, hand, Mode::Constrained, wb);
    ASSERT_EQ(x.graphic.position, y.graphic.position) << n;
    ASSERT_EQ(x.wrench.torque, y.wrench.torque) << n;
    ASSERT_EQ(x.pairs, y.pairs);
    for (const Contact& c : contacts(wa)) ASSERT_FALSE(c.on_skin);
  }
  // The published algorithm touches leaves with any contact surface.
  with.contact = ContactSurface::Skin;
  ASSERT_TRUE(compileScene(with, a, fault));
  Workspace wc(a), wd(b);
  for (int n = 0; n < 200; ++n) {
    hand = moved(hand, {test::randomPoint(random, 0.4) - 0.03 * hand.position, test::randomPoint(random, 0.02)});
    const StepResult x = step(a, hand, Mode::Published, wc), y = step(b, hand, Mode::Published, wd);
    ASSERT_EQ(x.graphic.position, y.graphic.position) << n;
    ASSERT_EQ(x.pairs, y.pairs);
  }
}

TEST(SkinStep, KernelsAndRunsGiveTheSameBytes) {
  Rig rig(test::rodTree(12, 30, 0.4), withSkin(test::oneBallTree(6.5), test::cuspedSkin(3)));
  Workspace first(rig.scene, Kernel::Scalar), second(rig.scene, Kernel::Best), third(rig.scene, Kernel::Best);
  Random random(8);
  Configuration hand{{0, 0, 12}, kUpright};
  for (int n = 0; n < 600; ++n) {
    hand = moved(hand, {test::randomPoint(random, 0.4) - 0.03 * hand.position, test::randomPoint(random, 0.02)});
    const StepResult a = step(rig.scene, hand, Mode::Constrained, first), b = step(rig.scene, hand, Mode::Constrained, second),
                     c = step(rig.scene, hand, Mode::Constrained, third);
    for (const StepResult* other : {&b, &c}) {
      ASSERT_EQ(a.graphic.position, other->graphic.position) << n;
      ASSERT_EQ(a.graphic.orientation.coeffs(), other->graphic.orientation.coeffs());
      ASSERT_EQ(a.wrench.torque, other->wrench.torque);
      ASSERT_EQ(a.work, other->work);
      ASSERT_EQ(a.rows, other->rows);
    }
  }
}

}  // namespace
}  // namespace spheretree::runtime
