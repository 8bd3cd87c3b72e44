// SPDX-License-Identifier: Apache-2.0
// The rows of hulls against searches over many balls of each. Subject: rows.h
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "kernel/kernel.h"
#include "rows/rows.h"
#include "scene/hull_ways.h"
#include "search/find_pairs.h"
#include "state/step_memory.h"
#include "support/row_dot.h"
#include "support/sample_hulls.h"
#include "support/triangle_distance.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using test::Random;

struct HullRig {
  SphereTree tool;
  Skin skin;
  Scene scene;
  std::unique_ptr<Workspace> workspace;
  PairSet pairs, felt;
  RowSet rows;

  HullRig(const Hulls& hulls, Skin of, Kernel kernel = Kernel::Best) : tool(test::toolOf(hulls)), skin(std::move(of)) {
    SceneDescription d;
    d.tool = tool;
    d.objects.push_back({test::withSkin(test::oneBallTree(1), skin), {}});
    std::string fault;
    EXPECT_TRUE(compileScene(d, scene, fault)) << fault;
    workspace = std::make_unique<Workspace>(scene, kernel);
  }
  void make(const Configuration& pose, double margin, bool has_felt = false) {
    pairs = findPairs(pose, margin, PairsOf::ContactSurface, 1u << 30, workspace->memory());
    makeRowsAt(pose, margin, has_felt);
  }
  void makeRowsAt(const Configuration& pose, double margin, bool has_felt) {
    StepMemory& memory = workspace->memory();
    rows = makeRows(pairs, pose, RowForm::TrueDistance, Eigen::Matrix3d::Identity(), memory);
    felt = feltPairs(pairs, margin, memory);
    if (has_felt) addFeltRows(felt, pose, margin, rows, memory);
  }
  bool isIn(std::uint32_t row) const { return rows.b[row] > -1e29f && test::rowDot(rows, row, Vector6::Ones()) != 0; }
  double gap(std::uint32_t row) const { return static_cast<double>(-rows.b[row] / rows.weight[row]); }
  Vector3d normal(std::uint32_t row) const {
    Vector3d n;
    for (std::size_t k = 0; k < 3; ++k) n[static_cast<Eigen::Index>(k)] = static_cast<double>(rows.rows.a[k][row] / rows.weight[row]);
    return n;
  }
};

/// Calls `visit` with the balls at a grid of weights of each part: centre in the frame of the object, and radius.
template <class Visit>
void forBalls(const Hulls& hulls, const Configuration& pose, int grid, const Visit& visit) {
  for (const HullPart& part : hulls.parts) {
    const std::size_t count = ballCount(part);
    std::array<Vector3d, 3> c;
    std::array<double, 3> r{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Sphere& s = hulls.balls[part[k < count ? k : 0]];
      c[k] = pose.orientation * centreOf(s) + pose.position;
      r[k] = double{s.radius};
    }
    for (int i = 0; i <= (count > 1 ? grid : 0); ++i)
      for (int j = 0; j <= (count > 2 ? grid - i : 0); ++j) {
        const double u = static_cast<double>(i) / grid, v = static_cast<double>(j) / grid;
        visit(Vector3d(c[0] + u * (c[1] - c[0]) + v * (c[2] - c[0])), r[0] + u * (r[1] - r[0]) + v * (r[2] - r[0]));
      }
  }
}

double distanceOf(const Hulls& hulls, const Configuration& pose, const Skin& skin, int grid) {
  double least = std::numeric_limits<double>::infinity();
  forBalls(hulls, pose, grid, [&](const Vector3d& c, double r) {
    for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
      const SkinPatch patch = patchOf(skin, t);
      least = std::min(least, test::distanceToTriangle(c, {patch.position[0].cast<double>(), patch.position[1].cast<double>(),
                                                           patch.position[2].cast<double>()}) -
                                  r);
    }
  });
  return least;
}

Hulls slab() {
  return test::hullsOf({test::ballAt({0, 0, 0}, 0.5), test::ballAt({2, 0, 0}, 0.3), test::ballAt({0.5, 1.5, 0}, 0.8)},
                       {{0, kNoHullBall, kNoHullBall},
                        {1, kNoHullBall, kNoHullBall},
                        {2, kNoHullBall, kNoHullBall},
                        {0, 1, kNoHullBall},
                        {1, 2, kNoHullBall},
                        {2, 0, kNoHullBall},
                        {0, 1, 2}},
                       1);
}

std::vector<Hulls> sampleHulls() {
  return {test::ballHull(0.7),
          test::rodHulls({-2, 0, 0}, 0.8, {2, 0, 0}, 0.3, 1),
          test::rodHulls({-2, 0, 0}, 0.8, {2, 0, 0}, 0.3, 4),
          test::rodHulls({-2, 0, 0}, 0.5, {2, 0, 0}, 0.5, 1),
          slab(),
          test::discHulls(2, 0.5, 12)};
}

// Whether all balls are outside of a skin that is seen whole from the origin, with their centres.
bool isOutside(const Hulls& hulls, const Configuration& pose, const Skin& skin) {
  bool is_outside = true;
  forBalls(hulls, pose, 4, [&](const Vector3d& c, double) {
    for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
      Eigen::Matrix3d corners;
      for (int k = 0; k < 3; ++k) corners.col(k) = patchOf(skin, t).position[static_cast<std::size_t>(k)].cast<double>();
      const Vector3d w = corners.inverse() * c;
      if (w.minCoeff() >= 0 && w.sum() <= 1) is_outside = false;
    }
  });
  return is_outside;
}

// The smallest gap of the rows is the distance of the hulls and the triangles: they hold every way in which the two may
// touch, and hollow sides and corners are none.
TEST(HullRows, TheSmallestGapIsThatOfManyBalls) {
  for (const Skin& skin : {test::boxSkin({1.5, 1, 2}), test::facetedSkin(1)}) {
    int met = 0;
    for (const Hulls& hulls : sampleHulls()) {
      HullRig rig(hulls, skin);
      Random random(7);
      for (int n = 0; n < 40; ++n) {
        const Configuration pose{random.between(1.5, 7) * random.direction(), test::randomRotation(random)};
        const double distance = distanceOf(hulls, pose, rig.skin, 40);
        if (distance < 0.02 || distance > 2 || !isOutside(hulls, pose, skin)) continue;
        rig.make(pose, 2.5);
        ++met;
        ASSERT_LE(static_cast<double>(rig.rows.smallest_gap), distance + 1e-5) << "hulls of " << hulls.parts.size() << " parts, pose " << n;
        ASSERT_GE(static_cast<double>(rig.rows.smallest_gap), distance - 6e-3) << "hulls of " << hulls.parts.size() << " parts, pose " << n;
      }
    }
    EXPECT_GT(met, 50);
  }
}

struct Ways {
  int sides = 0;
  std::set<SkinPosition> corners;
};
Ways waysOf(const Skin& skin) {
  CompiledSkin compiled = compileSkin(skin, Vector3d::Zero());
  Ways out;
  std::size_t t = 0;
  for (const std::uint8_t ways : hullWays(skin, compiled.patch)) {
    out.sides += std::popcount(ways & 7u);
    for (std::size_t k = 0; k < 3; ++k) {
      if ((ways >> (3 + k) & 1) == 0) continue;
      EXPECT_TRUE(out.corners.insert(skin.vertices[skin.triangles[t].vertex[k]].position).second) << "counted twice";
    }
    ++t;
  }
  return out;
}
std::pair<int, int> countOf(const Skin& skin) {
  const Ways ways = waysOf(skin);
  return {ways.sides, static_cast<int>(ways.corners.size())};
}

// Sides and corners that triangles share are counted once, those that are hollow never.
TEST(HullRows, WaysAreTheSidesAndCornersThatStandOut) {
  EXPECT_EQ(countOf(test::boxSkin({1.5, 1, 2})), std::pair(12 + 6, 8));  // the diagonals are flat
  EXPECT_EQ(countOf(test::roundSkin(2)), std::pair(192, 66));
  EXPECT_EQ(countOf(test::gridSkin(1)), std::pair(5, 4));  // it is open, so that it has no outside
  Skin skin = test::facetedSkin(3);
  const Ways ways = waysOf(skin);
  const int side_count = 768, corner_count = 258;
  EXPECT_LT(ways.sides, side_count * 9 / 10);
  // A direction that makes obtuse angles with all sides of a corner shows that it counts.
  std::map<SkinPosition, std::vector<Vector3d>> sides_at;
  for (std::size_t t = 0; t < skin.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto at = patchOf(skin, t).position;
      sides_at[skin.vertices[skin.triangles[t].vertex[k]].position].push_back((at[(k + 1) % 3] - at[k]).cast<double>());
    }
  Random random(3);
  std::size_t shown = 0;
  for (const auto& [position, around] : sides_at)
    for (int n = 0; n < 20000; ++n) {
      const Vector3d d = random.direction();
      if (!std::ranges::all_of(around, [&](const Vector3d& side) { return d.dot(side) < 0; })) continue;
      EXPECT_TRUE(ways.corners.contains(position));
      ++shown;
      break;
    }
  EXPECT_LE(ways.corners.size(), shown + corner_count / 20);
  EXPECT_LT(ways.corners.size(), corner_count * 9 / 10);
  for (SkinTriangle& t : skin.triangles) std::swap(t.vertex[1], t.vertex[2]), std::swap(t.edge[0], t.edge[2]);
  EXPECT_EQ(countOf(skin), std::pair(side_count, corner_count)) << "inside out, it encloses nothing, and all of them count";
}

// Rounding takes no corner away: those of a cube stand out, however it is turned and its faces are divided.
TEST(HullRows, AllCornersOfATurnedBoxAreWays) {
  Random random(9);
  for (int n = 0; n < 100; ++n) {
    const Eigen::Matrix3d turn = test::randomRotation(random).toRotationMatrix();
    const Skin straight = test::boxSkin({1, 1, 1});
    test::SmoothMesh mesh;
    for (const SkinVertex& v : straight.vertices) {
      mesh.positions.emplace_back(turn * positionOf(straight, v.position).cast<double>());
      mesh.normals.push_back(Vector3d::UnitZ());
    }
    for (const SkinTriangle& t : straight.triangles) mesh.triangles.push_back(t.vertex);
    mesh.project = [](const Vector3d& p) { return p; };
    const auto [sides, corners] = countOf(test::skinOf(mesh));
    EXPECT_EQ(corners, 8);
    EXPECT_GE(sides, 12);
  }
}

// A row is the derivative of the gap: the smallest gap changes by it when the tool moves a little.
TEST(HullRows, AreTheDerivativesOfTheSmallestGap) {
  int met = 0;
  for (const Hulls& hulls : sampleHulls()) {
    HullRig rig(hulls, test::boxSkin({1.5, 1, 2}));
    Random random(8);
    for (int n = 0; n < 200; ++n) {
      const Configuration pose{random.inCube(4), test::randomRotation(random)};
      rig.make(pose, 2.5);
      const auto gap = static_cast<double>(rig.rows.smallest_gap);
      if (gap < 0.05 || gap > 2) continue;
      const double length = rig.scene.compiled().angle_length;
      for (int k = 0; k < 6; ++k) {
        constexpr double kStep = 2e-3;
        Vector6 y = Vector6::Zero();
        y[k] = kStep;
        rig.make(pose, 2.5);
        double predicted = std::numeric_limits<double>::infinity();
        for (std::uint32_t row = 0; row < rig.rows.rows.count; ++row)
          if (rig.isIn(row)) predicted = std::min(predicted, rig.gap(row) + test::rowDot(rig.rows, row, y));
        rig.make(moved(pose, {y.head<3>(), y.tail<3>() / length}), 2.5);
        ASSERT_NEAR(static_cast<double>(rig.rows.smallest_gap), predicted, 2e-5)
            << "hulls of " << hulls.parts.size() << " parts, pose " << n;
        ++met;
      }
    }
  }
  EXPECT_GT(met, 1000);
}

TEST(HullRows, AreTheSameBitsInBothKernels) {
  if (!isAvailable(Kernel::Avx2)) GTEST_SKIP() << "this machine has no AVX2";
  for (const Hulls& hulls : sampleHulls()) {
    HullRig a(hulls, test::roundSkin(2), Kernel::Scalar), b(hulls, test::roundSkin(2), Kernel::Avx2);
    Random random(9);
    for (int n = 0; n < 100; ++n) {
      const Configuration pose{6 * random.direction(), test::randomRotation(random)};
      a.make(pose, 1, true);
      b.make(pose, 1, true);
      ASSERT_EQ(a.rows.rows.count, b.rows.rows.count);
      for (std::size_t k = 0; k < 6; ++k) ASSERT_EQ(std::memcmp(a.rows.rows.a[k], b.rows.rows.a[k], a.rows.rows.count * sizeof(float)), 0);
      ASSERT_EQ(std::memcmp(a.rows.b, b.rows.b, a.rows.rows.count * sizeof(float)), 0);
      ASSERT_EQ(std::memcmp(a.rows.along, b.rows.along, a.rows.rows.count * sizeof(float)), 0);
    }
  }
}

// On a smooth sphere a convex hull rests with the ball that is nearest to the centre of the sphere.
TEST(HullRows, FeltRowsAreTheClosedFormOnASmoothSphere) {
  int met = 0;
  for (const Hulls& hulls : sampleHulls()) {
    HullRig rig(hulls, test::roundSkin(4));  // of radius 5
    Random random(10);
    for (int n = 0; n < 200; ++n) {
      const Configuration pose{random.between(5.6, 7.0) * random.direction(), test::randomRotation(random)};
      double distance = std::numeric_limits<double>::infinity();
      Vector3d way = Vector3d::Zero();
      forBalls(hulls, pose, 300, [&](const Vector3d& c, double r) {
        if (c.norm() - r - 5 < distance) distance = c.norm() - r - 5, way = c.normalized();
      });
      if (distance < -0.2 || distance > 0.3) continue;
      rig.make(pose, 0.4, true);
      // Beside its foot a ball also gets planes as rows; they lean more.
      double gap = 0;
      Vector3d normal = -way;
      for (std::uint32_t row = rig.rows.guarded; row < rig.rows.rows.count; ++row)
        if (rig.isIn(row) && (rig.normal(row) - way).norm() < (normal - way).norm()) gap = rig.gap(row), normal = rig.normal(row);
      ++met;
      ASSERT_NEAR(gap, distance, 5e-4) << "hulls of " << hulls.parts.size() << " parts, pose " << n;
      ASSERT_LT((normal - way).norm(), 0.01) << "hulls of " << hulls.parts.size() << " parts, pose " << n;
    }
  }
  EXPECT_GT(met, 100);
}

// Cones that continue each other are felt as round as what they stand for, here the rim of a disc.
TEST(HullRows, FeltRowsOfJoinedConesAreThoseOfTheirCurve) {
  Hulls disc = test::discHulls(2, 0.5, 24);
  disc.overhang_bound = 0.01f;
  HullRig rig(disc, test::roundSkin(4));  // of radius 5
  Random random(11);
  double leans = 0, off = 0;
  int met = 0;
  for (int n = 0; n < 800; ++n) {
    const Configuration pose{random.between(5.6, 7.4) * random.direction(), test::randomRotation(random)};
    const Vector3d ball = pose.orientation.inverse() * Vector3d(-pose.position);  // its centre, in the frame of the disc
    const double beside = std::hypot(ball.x(), ball.y());
    if (beside < 2) continue;  // the face is felt
    const Vector3d way = pose.orientation * (Vector3d(2 / beside * ball.x(), 2 / beside * ball.y(), 0) - ball);
    const double distance = way.norm() - 5.5;
    if (distance < -0.2 || distance > 0.3) continue;
    rig.make(pose, 0.4, true);
    int in = 0;
    for (std::uint32_t row = rig.rows.guarded; row < rig.rows.rows.count; ++row) {
      if (!rig.isIn(row) || (rig.normal(row) - way.normalized()).norm() > 0.1) continue;
      leans = std::max(leans, (rig.normal(row) - way.normalized()).norm());
      off = std::max(off, std::abs(rig.gap(row) - distance));
      ++in;
    }
    ASSERT_GE(in, 1) << "pose " << n;
    ++met;
  }
  EXPECT_GT(met, 100);
  EXPECT_LT(leans, 3e-3);  // the corners of the rim turn by 0.26
  EXPECT_LT(off, 5e-4);    // and lie 0.017 mm outside of its sides
}

// Of two cones that meet with balls of nearly the same radius, the felt radius goes over from one to the other.
TEST(HullRows, FeltRowsOfJoinedConesHaveNoStep) {
  constexpr double kStep = 0.008;
  Hulls rod = test::hullsOf({test::ballAt({-2, 0, 0}, 0.5), test::ballAt({0, 0, 0}, 0.5), test::ballAt({0, 0, 0}, 0.5 + kStep),
                             test::ballAt({2, 0, 0}, 0.5 + kStep)},
                            {{1, kNoHullBall, kNoHullBall}, {2, kNoHullBall, kNoHullBall}, {0, 1, kNoHullBall}, {2, 3, kNoHullBall}}, 2);
  rod.overhang_bound = 0.01f;
  HullRig rig(rod, test::roundSkin(5));  // of radius 5
  double before = 0;
  for (int k = 0; k <= 200; ++k) {
    const double x = -1 + 0.01 * k;  // of the touched place, from the joint
    rig.make({Vector3d(-x, 0, 5.55), Quaternion::Identity()}, 0.4, true);
    double gap = 1;
    for (std::uint32_t row = rig.rows.guarded; row < rig.rows.rows.count; ++row)
      if (rig.isIn(row)) gap = std::min(gap, rig.gap(row));
    if (k > 0) {
      ASSERT_NEAR(gap, before, 2e-4) << "at " << x;
    }
    if (k == 100) {
      EXPECT_NEAR(gap, 0.05 - kStep / 2, 5e-4);
    }
    before = gap;
  }
}

// Each pair in all of its ways.
std::uint32_t allWays(const RowRequest& q, const HullWays& w) {
  std::uint32_t* end = w.to;
  for (std::uint32_t i = 0; i < q.count; ++i)
    for (std::uint32_t way = 0; way < (q.hulls.span1[q.pairs[i] >> 16] == Sphere{} ? 1 : 3); ++way)
      *end++ = q.pairs[i] + (way * w.apart << 16);
  return static_cast<std::uint32_t>(end - w.to);
}

// The felt rows of the pairs and ways that are left out would have been satisfied always.
TEST(HullRows, NoPairThatRestsIsLeftOut) {
  std::size_t left_out = 0, in = 0;
  std::vector<Hulls> tools = sampleHulls();
  tools.push_back(test::discHulls(2, 0.5, 24));
  tools.back().overhang_bound = 0.01f;  // its cones are joined
  for (const Hulls& hulls : tools)
    for (const Skin& skin : {test::roundSkin(1), test::roundSkin(3), test::cuspedSkin(2), test::ellipsoidSkin({7, 5, 2}, 2)}) {
      HullRig some(hulls, skin), all(hulls, skin);
      KernelTable keeps_all = *all.workspace->memory().kernel;
      keeps_all.spreadWays = allWays;
      keeps_all.keepResting = [](const RowRequest& request, std::uint32_t*) { return request.count; };
      all.workspace->memory().kernel = &keeps_all;
      Random random(12);
      for (int n = 0; n < 150; ++n) {
        const Configuration pose{random.between(4, 8) * random.direction(), test::randomRotation(random)};
        // After the search, the tool moves by less than its margin.
        const double reach = some.workspace->memory().scene.tool.reach;
        const Configuration to{pose.position + 0.05 * random.direction(),
                               Eigen::Quaterniond(Eigen::AngleAxisd(0.8 / reach, random.direction())) * pose.orientation};
        for (HullRig* rig : {&some, &all}) {
          rig->make(pose, 1.3);
          ASSERT_FALSE(rig->pairs.coarse);
          rig->makeRowsAt(to, 0.4, true);
        }
        std::map<std::uint32_t, double> gaps;
        for (std::uint32_t row = some.rows.guarded; row < some.rows.rows.count; ++row)
          if (some.isIn(row)) gaps[some.felt.pairs[row - some.rows.guarded]] = some.gap(row);
        for (std::uint32_t row = all.rows.guarded; row < all.rows.rows.count; ++row) {
          if (!all.isIn(row) || all.gap(row) > 0.4) continue;
          const auto found = gaps.find(all.felt.pairs[row - all.rows.guarded]);
          ASSERT_NE(found, gaps.end()) << "hulls of " << hulls.parts.size() << " parts, pose " << n;
          ASSERT_NEAR(found->second, all.gap(row), 1e-5) << "hulls of " << hulls.parts.size() << " parts, pose " << n;
          ++in;
        }
        left_out += all.rows.rows.count - some.rows.rows.count;
      }
    }
  EXPECT_GT(in, 1000u);
  EXPECT_GT(left_out, 10 * in);
}

}  // namespace
}  // namespace spheretree::runtime
