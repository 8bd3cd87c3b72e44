// SPDX-License-Identifier: Apache-2.0
// The rows of triangles and of smooth patches against searches in double. Subject: rows.h
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Dense>

#include "rows/rows.h"
#include "search/find_pairs.h"
#include "state/step_memory.h"
#include "support/row_dot.h"
#include "support/sample_skins.h"
#include "support/shape_trees.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using test::Random;
using test::rowDot;

Vector3d nodeOf(const std::array<Eigen::Vector3f, 6>& field, std::size_t k) { return field[k].cast<double>(); }

// A tool over one object with a skin; rows of every triangle within `margin`.
struct SkinRig {
  Skin skin;
  Configuration at;
  Scene scene;
  std::unique_ptr<Workspace> workspace;
  PairSet pairs, curved;
  RowSet rows;

  SkinRig(SphereTree tool, Skin of, const Configuration& object = {}, Kernel kernel = Kernel::Best) : skin(std::move(of)), at(object) {
    SceneDescription d;
    d.tool = std::move(tool);
    d.objects.push_back({test::withSkin(test::oneBallTree(1), skin), at});
    std::string fault;
    EXPECT_TRUE(compileScene(d, scene, fault)) << fault;
    workspace = std::make_unique<Workspace>(scene, kernel);
  }
  StepMemory& memory() { return workspace->memory(); }
  void make(const Configuration& pose, double margin, bool felt) {
    pairs = findPairs(pose, margin, PairsOf::ContactSurface, 1u << 30, memory());
    rows = makeRows(pairs, pose, RowForm::TrueDistance, Eigen::Matrix3d::Identity(), memory());
    curved = feltPairs(pairs, margin, memory());
    if (felt) addFeltRows(curved, pose, margin, rows, memory());
  }
  SkinPatch patchOfPair(std::uint32_t pair) const { return patchOf(skin, scene.compiled().shapeOf(0).skin.tree.item.at(pair & 0xffff)); }
  Vector3d centreOf(std::uint32_t pair, const Configuration& pose) const {  // in the frame of the skin
    const std::array<double, 3>& c = scene.compiled().tool.exact[pair >> 16];
    return at.orientation.conjugate() * (pose.orientation * Vector3d(c[0], c[1], c[2]) + pose.position - at.position);
  }
  double gap(std::uint32_t row) const { return static_cast<double>(-rows.b[row] / rows.weight[row]); }
  bool isIn(std::uint32_t row) const { return rows.b[row] > -1e29f; }
  Vector3d normal(std::uint32_t row) const {  // in the frame of the skin
    Vector3d n;
    for (std::size_t k = 0; k < 3; ++k) n[static_cast<Eigen::Index>(k)] = static_cast<double>(rows.rows.a[k][row] / rows.weight[row]);
    return at.orientation.conjugate() * n;
  }
};

Vector3d nearestOnSegment(const Vector3d& c, const Vector3d& a, const Vector3d& b) {
  const double square = (b - a).squaredNorm();
  return square > 0 ? a + std::clamp((c - a).dot(b - a) / square, 0.0, 1.0) * (b - a) : a;
}

Vector3d nearestOnTriangle(const Vector3d& c, const std::array<Vector3d, 3>& p) {
  Vector3d best = nearestOnSegment(c, p[0], p[1]);
  const auto offer = [&](const Vector3d& q) {
    if ((q - c).squaredNorm() < (best - c).squaredNorm()) best = q;
  };
  offer(nearestOnSegment(c, p[1], p[2]));
  offer(nearestOnSegment(c, p[2], p[0]));
  Eigen::Matrix2d normal_equations;
  const Vector3d u = p[1] - p[0], v = p[2] - p[0];
  normal_equations << u.dot(u), u.dot(v), u.dot(v), v.dot(v);
  if (normal_equations.determinant() > 1e-12 * u.squaredNorm() * v.squaredNorm()) {
    const Eigen::Vector2d w = normal_equations.inverse() * Eigen::Vector2d(u.dot(c - p[0]), v.dot(c - p[0]));
    if (w.minCoeff() >= 0 && w.sum() <= 1) offer(p[0] + w[0] * u + w[1] * v);
  }
  return best;
}

// Triangles without common vertices; some are needles, segments and points.
Skin randomSoup(std::uint64_t seed) {
  Random random(seed);
  test::SmoothMesh mesh;
  for (int t = 0; t < 60; ++t) {
    const auto first = static_cast<std::uint16_t>(mesh.positions.size());
    const Vector3d a = random.inCube(4), b = random.inCube(4), c = random.inCube(4);
    const std::array corners = t % 6 == 0   ? std::array{a, b, a}                                              // a segment
                               : t % 6 == 1 ? std::array{a, Vector3d(0.3 * a + 0.7 * b), b}                    // flat
                               : t % 6 == 2 ? std::array{a, b, Vector3d(0.5 * (a + b) + random.inCube(0.01))}  // a needle
                               : t % 6 == 3 ? std::array{a, a, a}
                                            : std::array{a, b, c};
    for (const Vector3d& p : corners) mesh.positions.push_back(p);
    mesh.triangles.push_back({first, static_cast<std::uint16_t>(first + 1), static_cast<std::uint16_t>(first + 2)});
  }
  mesh.normals.assign(mesh.positions.size(), Vector3d::UnitZ());
  mesh.project = [](const Vector3d& p) { return p; };
  return test::skinOf(mesh);
}

TEST(FlatRows, AreTheNearestPointsOfTriangles) {
  std::array<int, 4> met{};  // at a corner, on a side, over the face from above, from below
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SkinRig rig(test::oneBallTree(1), randomSoup(seed));
    Random random(100 + seed);
    for (int n = 0; n < 60; ++n) {
      const Configuration pose{random.inCube(5), {1, 0, 0, 0}};
      rig.make(pose, 3, true);
      ASSERT_EQ(rig.rows.rows.count, rig.pairs.pairs.size());  // flat patches have no felt rows
      for (std::uint32_t k = 0; k < rig.rows.rows.count; ++k) {
        const SkinPatch patch = rig.patchOfPair(rig.pairs.pairs[k]);
        const std::array<Vector3d, 3> p{nodeOf(patch.position, 0), nodeOf(patch.position, 1), nodeOf(patch.position, 2)};
        const Vector3d c = rig.centreOf(rig.pairs.pairs[k], pose), q = nearestOnTriangle(c, p), normal = rig.normal(k);
        const double distance = (c - q).norm();
        ASSERT_NEAR(rig.gap(k), distance - 1, 1e-5);
        ASSERT_NEAR(normal.norm(), 1, 1e-5);
        // The plane through the nearest point has the whole triangle behind it: the row never requires less than the
        // triangle does. In float, a point may be taken for the nearest that is farther by 1e-7 of the distance and
        // displaced by about 1e-4 of it.
        for (const Vector3d& corner : p) ASSERT_LE(normal.dot(corner - c), -distance + 5e-3) << c.transpose();
        if (distance > 0.05) {
          ASSERT_LT((normal - (c - q) / distance).norm(), 1e-3);
        }
        int corners = 0, sides = 0;
        for (std::size_t i = 0; i < 3; ++i) {
          corners += (q - p[i]).norm() < 1e-9;
          sides += (nearestOnSegment(q, p[i], p[(i + 1) % 3]) - q).norm() < 1e-9;
        }
        const double height = (p[1] - p[0]).cross(p[2] - p[0]).dot(c - p[0]);
        ++met[corners > 0 ? 0 : sides > 0 ? 1 : height > 0 ? 2 : 3];
      }
    }
  }
  for (const int count : met) EXPECT_GT(count, 200);
}

TEST(FlatRows, GiveWayByTheAllowance) {
  Skin skin = test::roundSkin(3);
  skin.tolerance = 0.2f;
  SkinRig rig(test::oneBallTree(1), skin);
  Random random(3);
  int rows = 0;
  for (int n = 0; n < 50; ++n) {
    const Configuration pose{5.9 * random.direction(), {1, 0, 0, 0}};
    rig.make(pose, 1, false);
    for (std::uint32_t k = 0; k < rig.rows.rows.count; ++k, ++rows) {
      const SkinPatch patch = rig.patchOfPair(rig.pairs.pairs[k]);
      const Vector3d c = rig.centreOf(rig.pairs.pairs[k], pose),
                     q = nearestOnTriangle(c, {nodeOf(patch.position, 0), nodeOf(patch.position, 1), nodeOf(patch.position, 2)});
      ASSERT_NEAR(rig.gap(k), (c - q).norm() - 0.8, 1e-5);
    }
  }
  EXPECT_GT(rows, 500);
  // A ball that is smaller than the allowance keeps half of itself.
  SkinRig small(test::oneBallTree(0.1), skin);
  small.make({{5, 0, 0}, {1, 0, 0, 0}}, 0.5, false);
  ASSERT_GT(small.rows.rows.count, 0u);
  EXPECT_NEAR(static_cast<double>(small.rows.smallest_gap), 0 - 0.05, 1e-4);
}

TEST(FlatRows, AreTheDerivativeOfTheDistance) {
  const Configuration at{{3, -2, 1}, rotationOf({0.4, -0.7, 0.2})};
  SkinRig rig(test::rodTree(6, 12, 0.5), randomSoup(7), at);
  Random random(8);
  const auto distance = [&](std::uint32_t pair, const Configuration& pose) {
    const SkinPatch patch = rig.patchOfPair(pair);
    const Vector3d c = rig.centreOf(pair, pose);
    return (c - nearestOnTriangle(c, {nodeOf(patch.position, 0), nodeOf(patch.position, 1), nodeOf(patch.position, 2)})).norm();
  };
  int checked = 0;
  for (int n = 0; n < 20; ++n) {
    const Configuration pose{at.position + random.inCube(4), test::randomRotation(random)};
    rig.make(pose, 1, false);
    const Displacement step{random.inCube(1), random.inCube(0.05)};
    Vector6 y;
    y << step.translation, rig.scene.compiled().angle_length * step.rotation;
    const auto along = [&](double t) { return moved(pose, {t * step.translation, t * step.rotation}); };
    for (std::uint32_t k = 0; k < rig.rows.rows.count; ++k) {
      const std::uint32_t pair = rig.pairs.pairs[k];
      if (distance(pair, pose) < 0.1) continue;  // closer than this, the normal rotates within the difference quotient
      EXPECT_NEAR(rowDot(rig.rows, k, y), (distance(pair, along(1e-5)) - distance(pair, along(-1e-5))) / 2e-5, 5e-4);
      ++checked;
    }
  }
  EXPECT_GT(checked, 300);
}

// Position or normal of a patch, by the polynomials of core/skin.h.
Vector3d valueAt(const std::array<Eigen::Vector3f, 6>& nodes, double u, double v) {
  const double w = 1 - u - v;
  return w * (2 * w - 1) * nodeOf(nodes, 0) + u * (2 * u - 1) * nodeOf(nodes, 1) + v * (2 * v - 1) * nodeOf(nodes, 2) +
         4 * w * u * nodeOf(nodes, 3) + 4 * u * v * nodeOf(nodes, 4) + 4 * v * w * nodeOf(nodes, 5);
}

struct Foot {
  double u, v, gap;  // of a point: distance to the patch along its normal
  Vector3d normal;   // of unit length
};

// The point whose normal points at `c`: the best of a grid, then Newton's steps with difference quotients. Empty if it
// is outside the patch.
std::optional<Foot> footOf(const SkinPatch& patch, const Vector3d& c) {
  const auto rest = [&](double u, double v) -> Vector3d {
    const Vector3d n = valueAt(patch.normal, u, v).normalized(), way = c - valueAt(patch.position, u, v);
    return way - way.dot(n) * n;
  };
  double u = 0, v = 0, smallest = std::numeric_limits<double>::infinity();
  constexpr int kGrid = 24;
  for (int i = 0; i <= kGrid; ++i)
    for (int j = 0; i + j <= kGrid; ++j)
      if (const double off = rest(1.0 * i / kGrid, 1.0 * j / kGrid).norm(); off < smallest) {
        smallest = off;
        u = 1.0 * i / kGrid;
        v = 1.0 * j / kGrid;
      }
  for (int step = 0; step < 30; ++step) {
    constexpr double h = 1e-6;
    Eigen::Matrix<double, 3, 2> slope;
    slope.col(0) = (rest(u + h, v) - rest(u - h, v)) / (2 * h);
    slope.col(1) = (rest(u, v + h) - rest(u, v - h)) / (2 * h);
    const Eigen::Vector2d change = slope.colPivHouseholderQr().solve(-rest(u, v));
    u += change[0];
    v += change[1];
  }
  if (!(rest(u, v).norm() < 1e-9) || u < 1e-3 || v < 1e-3 || u + v > 1 - 1e-3) return std::nullopt;
  const Vector3d normal = valueAt(patch.normal, u, v).normalized();
  return Foot{u, v, normal.dot(c - valueAt(patch.position, u, v)), normal};
}

TEST(FeltRows, AreTheFeetOnThePatches) {
  int within = 0;
  for (const int times : {0, 1, 2, 3}) {
    SkinRig rig(test::oneBallTree(1), test::roundSkin(times), {{10, -20, 5}, rotationOf({0.5, 0.4, -0.3})});
    Random random(static_cast<std::uint64_t>(times + 1));
    for (int n = 0; n < 200; ++n) {
      const Configuration pose{rig.at.position + random.between(5.2, 6.3) * random.direction(), {1, 0, 0, 0}};
      rig.make(pose, 1.5, true);
      for (std::uint32_t k = 0; k < rig.curved.pairs.size(); ++k) {
        const std::uint32_t pair = rig.curved.pairs[k], row = rig.rows.guarded + k;
        const std::optional<Foot> foot = footOf(rig.patchOfPair(pair), rig.centreOf(pair, pose));
        if (!foot || foot->gap < 0) continue;
        ASSERT_TRUE(rig.isIn(row)) << times << ' ' << n << " foot " << foot->u << ' ' << foot->v;
        ASSERT_NEAR(rig.gap(row), foot->gap - 1, 1e-5);
        ASSERT_LT((rig.normal(row) - foot->normal).norm(), 1e-3);
        ++within;
      }
    }
  }
  EXPECT_GT(within, 500);
}

TEST(FeltRows, HoldABallOnTheSmoothSphere) {
  // For every direction, some row touches the ball, and none pushes it away by more than the fineness of the skin.
  for (const int times : {2, 3, 4}) {
    SkinRig rig(test::oneBallTree(1), test::roundSkin(times));
    const double off = times == 2 ? 0.03 : times == 3 ? 2e-3 : 3e-4;
    Random random(static_cast<std::uint64_t>(10 + times));
    for (int n = 0; n < 500; ++n) {
      const Vector3d way = random.direction();
      rig.make({6 * way, {1, 0, 0, 0}}, 0.3, true);
      double smallest = std::numeric_limits<double>::infinity();
      Vector3d normal = Vector3d::Zero();
      for (std::uint32_t k = rig.rows.guarded; k < rig.rows.rows.count; ++k)
        if (rig.isIn(k) && rig.gap(k) < smallest) {
          smallest = rig.gap(k);
          normal = rig.normal(k);
        }
      ASSERT_NEAR(smallest, 0, off) << times << ' ' << way.transpose();
      ASSERT_NEAR(static_cast<double>(rig.rows.smallest_felt_gap), smallest, 1e-5);
      ASSERT_LT((normal - way).norm(), times == 2 ? 0.05 : 0.01) << times << ' ' << way.transpose();
    }
  }
}

TEST(FeltRows, MeetSharpSidesAsSegments) {
  SkinRig rig(test::oneBallTree(0.5), test::ridgeSkin());
  Random random(5);
  int held = 0;
  for (int n = 0; n < 300; ++n) {
    // In the wedge above the ridge, which contains no normal of either strip.
    const double angle = random.between(-0.4, 0.4), distance = random.between(0.4, 0.9);
    const Vector3d c(distance * std::sin(angle), random.between(-1.5, 1.5), distance * std::cos(angle));
    rig.make({c, {1, 0, 0, 0}}, 0.6, true);
    const Vector3d out(std::sin(angle), 0, std::cos(angle));
    int of_ridge = 0;
    for (std::uint32_t k = rig.rows.guarded; k < rig.rows.rows.count; ++k)
      of_ridge += rig.isIn(k) && std::abs(rig.gap(k) - (distance - 0.5)) < 1e-4 && (rig.normal(k) - out).norm() < 2e-3;
    held += of_ridge > 0;
  }
  EXPECT_EQ(held, 300);
}

constexpr double kHill = 0.3, kWave = 1.5;  // height [mm], wave number [1/mm]

Vector3d onHills(const Vector3d& p) { return {p.x(), p.y(), kHill * std::sin(kWave * p.x()) * std::sin(kWave * p.y())}; }

Vector3d hillNormal(const Vector3d& p) {
  const double x = kWave * p.x(), y = kWave * p.y(), slope = kHill * kWave;
  return Vector3d(-slope * std::cos(x) * std::sin(y), -slope * std::sin(x) * std::cos(y), 1).normalized();
}

/// Hills and hollows over the square from 0 to 8, seen from above.
Skin hillySkin(int n) {
  test::SmoothMesh mesh;
  const auto at = [n](int i, int j) { return static_cast<std::uint16_t>(i * (n + 1) + j); };
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      mesh.positions.push_back(onHills({8.0 * i / n, 8.0 * j / n, 0}));
      mesh.normals.push_back(hillNormal(mesh.positions.back()));
    }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  mesh.project = onHills;
  return skinOf(mesh);
}

// The shortest motion of a ball of radius `r` about `c` after which it touches the patch at one of a grid of points,
// with its centre at distance `r` above the point along the normal; a patch with a sharp side can be touched from
// anywhere.
double wayToTouch(const SkinPatch& patch, const Vector3d& c, double r) {
  const bool is_sharp = patch.is_sharp[0] || patch.is_sharp[1] || patch.is_sharp[2];
  double smallest = std::numeric_limits<double>::infinity();
  constexpr int kGrid = 12;
  for (int i = 0; i <= kGrid; ++i)
    for (int j = 0; i + j <= kGrid; ++j) {
      const double u = 1.0 * i / kGrid, v = 1.0 * j / kGrid;
      const Vector3d p = valueAt(patch.position, u, v), there = p + r * valueAt(patch.normal, u, v).normalized();
      smallest = std::min(smallest, is_sharp ? (c - p).norm() - r : (c - there).norm());
    }
  return smallest;
}

TEST(FeltPairs, AreAllThatABallCanComeToTouch) {
  constexpr double kWay = 0.06;
  for (const double radius : {0.1, 0.5, 2.0}) {
    std::size_t near = 0, kept = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      const Skin skin = seed == 1   ? test::roundSkin(4)
                        : seed == 2 ? test::roundSkin(2)
                        : seed == 3 ? hillySkin(32)
                        : seed == 4 ? hillySkin(8)
                        : seed == 5 ? test::ridgeSkin()
                                    : test::randomSkin(seed);
      SkinRig rig(test::oneBallTree(static_cast<float>(radius)), skin, {{3, 1, -2}, rotationOf({0.3, 1.2, -0.5})});
      Random random(seed);
      for (int n = 0; n < 60; ++n) {
        const SkinPatch under =
            patchOf(skin, static_cast<std::size_t>(random.between(0, 0.999 * static_cast<double>(skin.triangles.size()))));
        const Vector3d c = valueAt(under.position, 0.3, 0.4) + radius * valueAt(under.normal, 0.3, 0.4).normalized() + random.inCube(0.1);
        rig.make({rig.at.position + rig.at.orientation * c, {1, 0, 0, 0}}, 0.3, false);
        const PairSet curved = feltPairs(rig.pairs, kWay, rig.memory());
        near += rig.pairs.pairs.size();
        kept += curved.pairs.size();
        for (const std::uint32_t pair : rig.pairs.pairs) {
          const SkinPatch patch = rig.patchOfPair(pair);
          if (allowanceOf(patch, 1) == 0) continue;
          if (std::find(curved.pairs.begin(), curved.pairs.end(), pair) != curved.pairs.end()) continue;
          ASSERT_GT(wayToTouch(patch, c, radius), kWay - 1e-4) << radius << ' ' << seed << ' ' << n;
        }
      }
    }
    EXPECT_GT(near, 1000u);
    if (radius < 2) {
      EXPECT_LT(kept, near / 2) << radius;
    }
  }
}

TEST(SkinRows, AreTheSameWhereverTheObjectStands) {
  const Configuration there{{40, -7, 12}, rotationOf({1.1, -0.4, 2.0})};
  SkinRig here(test::rodTree(5, 10, 0.5), test::roundSkin(2)), moved_there(test::rodTree(5, 10, 0.5), test::roundSkin(2), there);
  Random random(6);
  std::size_t compared = 0;
  for (int n = 0; n < 50; ++n) {
    const Configuration pose{5.5 * random.direction(), test::randomRotation(random)};
    here.make(pose, 0.5, true);
    moved_there.make({there.position + there.orientation * pose.position, there.orientation * pose.orientation}, 0.5, true);
    // Rounding may include a pair at the margin in one case only: compare by name.
    for (std::uint32_t k = 0; k < here.pairs.pairs.size(); ++k) {
      const auto other = std::find(moved_there.pairs.pairs.begin(), moved_there.pairs.pairs.end(), here.pairs.pairs[k]);
      if (other == moved_there.pairs.pairs.end()) {
        ASSERT_GT(here.gap(k), 0.49);
        continue;
      }
      const auto row = static_cast<std::uint32_t>(other - moved_there.pairs.pairs.begin());
      ASSERT_NEAR(here.gap(k), moved_there.gap(row), 2e-5);
      ASSERT_LT((here.normal(k) - moved_there.normal(row)).norm(), 1e-3);
      ++compared;
    }
    ASSERT_NEAR(static_cast<double>(here.rows.smallest_felt_gap), static_cast<double>(moved_there.rows.smallest_felt_gap), 3e-5) << n;
  }
  EXPECT_GT(compared, 500u);
}

TEST(SkinRows, KernelsGiveTheSameBits) {
  if (!isAvailable(Kernel::Avx2)) GTEST_SKIP() << "no AVX2 here";
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const Skin skin = seed % 4 == 0 ? randomSoup(seed) : test::randomSkin(seed);
    const Configuration at{{1, 2, 3}, rotationOf({0.1, 0.9, -0.4})};
    SkinRig scalar(test::rodTree(5, 20, 0.4), skin, at, Kernel::Scalar), avx2(test::rodTree(5, 20, 0.4), skin, at, Kernel::Avx2);
    ASSERT_NE(scalar.memory().kernel, avx2.memory().kernel);
    Random random(seed);
    for (int n = 0; n < 20; ++n) {
      const Configuration pose{at.position + random.inCube(6), test::randomRotation(random)};
      scalar.make(pose, 0.8, true);
      avx2.make(pose, 0.8, true);
      const RowSet &a = scalar.rows, &b = avx2.rows;
      ASSERT_TRUE(std::equal(scalar.pairs.pairs.begin(), scalar.pairs.pairs.end(), avx2.pairs.pairs.begin(), avx2.pairs.pairs.end()));
      ASSERT_TRUE(std::equal(scalar.curved.pairs.begin(), scalar.curved.pairs.end(), avx2.curved.pairs.begin(), avx2.curved.pairs.end()));
      ASSERT_EQ(a.rows.count, b.rows.count);
      for (std::size_t i = 0; i < 6; ++i) ASSERT_TRUE(std::equal(a.rows.a[i], a.rows.a[i] + a.rows.count, b.rows.a[i])) << seed << ' ' << n;
      ASSERT_TRUE(std::equal(a.rows.b, a.rows.b + a.rows.count, b.rows.b));
      ASSERT_EQ(a.smallest_gap, b.smallest_gap);
      ASSERT_EQ(a.smallest_felt_gap, b.smallest_felt_gap);
      for (std::uint32_t k = 0; k < a.rows.count; ++k) ASSERT_TRUE(std::isfinite(a.rows.b[k])) << seed << ' ' << n << ' ' << k;
    }
  }
}

TEST(SkinRows, KeepNearLosesNothingThatIsFelt) {
  // A ball on the patches; their flat triangles are deeper by the swing and allow the tolerance.
  for (const int times : {1, 2, 3}) {
    SkinRig rig(test::oneBallTree(1), test::roundSkin(times));
    Random random(static_cast<std::uint64_t>(times));
    for (int n = 0; n < 200; ++n) {
      const Configuration pose{6.005 * random.direction(), {1, 0, 0, 0}};
      rig.make(pose, 1, true);
      std::vector<double> near;
      for (std::uint32_t k = rig.rows.guarded; k < rig.rows.rows.count; ++k)
        if (rig.isIn(k) && rig.gap(k) < 0.01) near.push_back(rig.gap(k));
      rig.make(pose, 1, false);
      keepNear(0.01, rig.pairs, rig.rows, rig.memory());
      PairSet curved = feltPairs(rig.pairs, 1, rig.memory());
      addFeltRows(curved, pose, 1, rig.rows, rig.memory());
      std::vector<double> kept;
      for (std::uint32_t k = rig.rows.guarded; k < rig.rows.rows.count; ++k)
        if (rig.isIn(k) && rig.gap(k) < 0.01) kept.push_back(rig.gap(k));
      ASSERT_EQ(near.size(), kept.size()) << times << ' ' << n;
      for (std::size_t k = 0; k < near.size(); ++k) ASSERT_NEAR(near[k], kept[k], 1e-6);
    }
  }
}

}  // namespace
}  // namespace spheretree::runtime
