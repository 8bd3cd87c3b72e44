// SPDX-License-Identifier: GPL-3.0-or-later
#include "certify/certify_cover.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "support/dense_points.h"
#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

CertifiedCover certify(const TriangleMesh& mesh, std::span<const Ball> balls, double resolution,
                       const Vector3d& origin = Vector3d::Zero()) {
  Progress progress;
  return certifyCover(mesh, balls, origin, resolution, progress);
}

std::vector<CoverGap> gapsOf(const TriangleMesh& mesh, std::span<const Ball> balls, double tolerance) {
  Progress progress;
  std::vector<std::uint32_t> all(mesh.triangles.size());
  std::iota(all.begin(), all.end(), 0u);
  return findCoverGaps(mesh, all, balls, tolerance, progress);
}

double deepest(const std::vector<CoverGap>& gaps) {
  double largest = 0;
  for (const CoverGap& g : gaps) largest = std::max(largest, g.gap);
  return largest;
}

// An open mesh: certification does not need a closed one.
TriangleMesh rectangle(double half_x, double half_y) {
  TriangleMesh mesh;
  mesh.positions = {{-half_x, -half_y, 0}, {half_x, -half_y, 0}, {half_x, half_y, 0}, {-half_x, half_y, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

// `count` balls about random points of the surface, large enough to leave a few holes.
std::vector<Ball> scattered(const TriangleMesh& mesh, std::size_t count, double radius, std::uint64_t seed) {
  test::Random random(seed);
  const std::vector<Vector3d> points = test::densePoints(mesh, 3, seed);
  std::vector<Ball> balls;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = random.below(points.size());
    const double r = radius * random.between(0.8, 1.2);
    balls.push_back({points[at] + 0.2 * radius * random.inCube(1), r});
  }
  return balls;
}

void expectCovered(const TriangleMesh& mesh, const CertifiedCover& cover, const Vector3d& origin = Vector3d::Zero()) {
  const std::vector<Ball> balls = test::toBalls(cover.spheres, origin);
  // Far from the origin, the test points themselves are rounded.
  const double rounding = 4e-16 * origin.cwiseAbs().maxCoeff();
  EXPECT_LE(test::largestGap(test::densePoints(mesh, 20, 77), balls), rounding);
}

TEST(CertifyCover, CoversEveryTriangleByTheStoredSpheres) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const TriangleMesh mesh = seed % 2 ? test::torusMesh(5, 2, 24, 12) : test::boxMesh({-5, -1, 0}, {4, 2, 0.5});
    const std::vector<Ball> balls = scattered(mesh, 60, 1.6, seed);
    const CertifiedCover cover = certify(mesh, balls, 0.02);
    ASSERT_EQ(cover.spheres.size(), balls.size());
    EXPECT_GT(cover.largest_growth, 0) << "this set has holes to close";
    EXPECT_GE(cover.pieces, mesh.triangles.size());
    expectCovered(mesh, cover);
  }
}

TEST(CertifyCover, NeverShrinksNorMovesABall) {
  const TriangleMesh mesh = test::torusMesh(5, 2, 24, 12);
  const std::vector<Ball> balls = scattered(mesh, 60, 1.6, 3);
  const CertifiedCover cover = certify(mesh, balls, 0.02);
  double largest = 0;
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const Sphere& s = cover.spheres[i];
    EXPECT_EQ(Vector3d(s.x, s.y, s.z), balls[i].centre.cast<float>().cast<double>());
    EXPECT_GE(s.radius, static_cast<float>(balls[i].radius));
    largest = std::max(largest, static_cast<double>(s.radius) - static_cast<double>(static_cast<float>(balls[i].radius)));
  }
  EXPECT_NEAR(cover.largest_growth, largest, 1e-6);
}

TEST(CertifyCover, ACoverDoesNotGrow) {
  const TriangleMesh mesh = test::sphereMesh(3, 3);
  const std::vector<Ball> one{{{0, 0, 0}, 3.0001}};
  const CertifiedCover cover = certify(mesh, one, 1e-3);
  EXPECT_EQ(cover.largest_growth, 0);
  EXPECT_EQ(cover.pieces, mesh.triangles.size()) << "no triangle needs a split";
  // Two triangles that lie in the union of two balls, but in neither ball alone.
  const std::vector<Ball> two{{{-1, 0, 0}, 1.5}, {{1, 0, 0}, 1.5}};
  const CertifiedCover split = certify(rectangle(2, 0.5), two, 1e-3);
  EXPECT_EQ(split.largest_growth, 0);
  EXPECT_GT(split.pieces, 2u);
  expectCovered(rectangle(2, 0.5), split);
}

// Two balls over a strip leave a hole at the sides of its middle; the deepest points are (0, +-half width).
TEST(CertifyCover, ClosesAKnownGapByTheLeastGrowth) {
  const double half_width = 0.3, resolution = 1e-3;
  const TriangleMesh strip = rectangle(1.4, half_width);
  for (const double radius : {1.01, 0.99, 0.8}) {
    const double gap = std::hypot(1.0, half_width) - radius;
    const CertifiedCover cover = certify(strip, std::vector<Ball>{{{-1, 0, 0}, radius}, {{1, 0, 0}, radius}}, resolution);
    expectCovered(strip, cover);
    EXPECT_GE(cover.largest_growth, gap - 1e-6);
    EXPECT_LE(cover.largest_growth, gap + 1.01 * resolution);
  }
}

TEST(CertifyCover, WorksFarFromTheOrigin) {
  const Vector3d shift(1e6, -2e6, 3e6);
  const TriangleMesh near = test::torusMesh(5, 2, 24, 12), far = test::moved(near, shift);
  std::vector<Ball> balls = scattered(near, 60, 1.6, 5);
  const CertifiedCover here = certify(near, balls, 0.02);
  for (Ball& b : balls) b.centre += shift;
  const CertifiedCover there = certify(far, balls, 0.02, shift);
  expectCovered(far, there, shift);
  for (std::size_t i = 0; i < balls.size(); ++i) EXPECT_NEAR(there.spheres[i].radius, here.spheres[i].radius, 0.02);
  EXPECT_LT(there.largest_growth, here.largest_growth + 0.02);
}

// Few small balls far from large triangles: the work must not grow with the square of the number of open pieces.
TEST(CertifyCover, LargeHolesTakeFewPieces) {
  const TriangleMesh plane = rectangle(10, 10);
  std::vector<std::vector<Ball>> sets{
      {{{0, 0, 40}, 1}}, {{{-30, 0, 9}, 1}, {{30, 5, 9}, 1}}, {{{-8, -8, 5}, 1}, {{8, 8, -5}, 1}, {{8, -7, 3}, 2}}};
  test::Random random(8);
  for (int k = 1; k < 6; ++k) {
    sets.emplace_back();
    for (int i = 0; i < k; ++i) sets.back().push_back({random.inBox({-9, -9, -9}, {9, 9, 9}), 1});
  }
  for (const std::vector<Ball>& balls : sets) {
    const CertifiedCover cover = certify(plane, balls, 5e-3);
    expectCovered(plane, cover);
    EXPECT_LT(cover.pieces, 200'000u) << balls.size() << " balls";
  }
}

// Triangles, some of them slivers, among a few balls that cover about half of them.
TEST(CertifyCover, AcceptsOnlyTrianglesWithoutABarePoint) {
  test::Random random(12);
  int covered = 0, grown = 0;
  for (int i = 0; i < 400; ++i) {
    TriangleMesh mesh;
    const double width = i % 2 ? 1 : 1e-3;
    mesh.positions = {random.inCube(1), random.inCube(1), Vector3d::Zero()};
    mesh.positions[2] = mesh.positions[0] + width * random.inCube(1);
    mesh.triangles = {{0, 1, 2}};
    std::vector<Ball> balls;
    for (int k = 0; k < 8; ++k) balls.push_back({0.7 * random.inCube(1), random.between(0.5, 0.9)});
    const CertifiedCover cover = certify(mesh, balls, 1e-3);
    EXPECT_LE(test::largestGap(test::densePoints(mesh, 1000, 5), test::toBalls(cover.spheres)), 0) << i;
    ++(cover.largest_growth == 0 ? covered : grown);
  }
  EXPECT_GT(covered, 100);
  EXPECT_GT(grown, 100);
}

// Two balls that meet at the border of a strip: 0.5^2 + 0.375^2 = 0.625^2. Where they only touch, rounding leaves a
// doubt, and they grow; larger by the least that float32 can hold, they cover it.
TEST(CertifyCover, GrowsWhereRoundingLeavesADoubt) {
  const TriangleMesh strip = rectangle(1, 0.375);
  const auto grown = [&](float radius) {
    const CertifiedCover cover = certify(strip, std::vector<Ball>{{{-0.5, 0, 0}, radius}, {{0.5, 0, 0}, radius}}, 1e-3);
    expectCovered(strip, cover);
    return cover.largest_growth;
  };
  EXPECT_EQ(grown(std::nextafter(0.625f, 1.0f)), 0);
  EXPECT_GT(grown(0.625f), 0);
  EXPECT_GT(grown(std::nextafter(0.625f, 0.0f)), 0);
}

// Slivers of 1:1000 across two balls that cover them, or nearly: a piece for each ball, and the least growth.
TEST(CertifyCover, SliversTakeFewPieces) {
  constexpr std::uint32_t kSlivers = 500;
  const double half_width = 0.5;
  TriangleMesh strips;
  for (std::uint32_t i = 0; i <= kSlivers; ++i)
    for (const double x : {-1.0, 1.0}) strips.positions.emplace_back(x, half_width * (2.0 * i / kSlivers - 1), 0);
  for (std::uint32_t i = 0; i < kSlivers; ++i)
    strips.triangles.insert(strips.triangles.end(), {{2 * i, 2 * i + 1, 2 * i + 3}, {2 * i, 2 * i + 3, 2 * i + 2}});
  for (const double gap : {-1e-3, 1e-3}) {
    const double radius = std::hypot(0.5, half_width) - gap;
    const CertifiedCover cover = certify(strips, std::vector<Ball>{{{-0.5, 0, 0}, radius}, {{0.5, 0, 0}, radius}}, 1e-4);
    expectCovered(strips, cover);
    EXPECT_NEAR(cover.largest_growth, std::max(gap, 0.0), 1e-6);
    EXPECT_LE(cover.pieces, 3 * strips.triangles.size());
  }
}

TEST(CertifyCover, RefusesWhatItCannotStore) {
  const TriangleMesh mesh = test::sphereMesh(1, 1);
  EXPECT_THROW(certify(mesh, {}, 1e-3), std::invalid_argument);
  for (const Ball& b : {Ball{{0, 0, 0}, 1e39}, Ball{{1e39, 0, 0}, 1}, Ball{{0, 0, 0}, std::nan("")}, Ball{{0, std::nan(""), 0}, 1}})
    EXPECT_THROW(certify(mesh, std::vector<Ball>{b}, 1e-3), std::invalid_argument);
}

TEST(CertifyCover, StopsWhenCancelled) {
  Progress progress;
  progress.cancel();
  EXPECT_THROW(certifyCover(test::sphereMesh(1, 1), std::vector<Ball>{{{0, 0, 0}, 2}}, Vector3d::Zero(), 1e-3, progress), Cancelled);
}

// Three equal balls about the corners of an equilateral triangle leave a hole whose deepest point is the middle.
TEST(FindCoverGaps, HoleBetweenThreeDiscsHasTheClosedForm) {
  const double side = 2;
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {side, 0, 0}, {side / 2, side * std::sqrt(3.0) / 2, 0}};
  mesh.triangles = {{0, 1, 2}};
  const Vector3d middle = (mesh.positions[0] + mesh.positions[1] + mesh.positions[2]) / 3;
  for (const double height : {0.0, 0.4})
    for (const double reach : {0.51 * side, 0.55 * side, 0.57 * side}) {  // of the discs in the plane
      std::vector<Ball> balls;
      for (const Vector3d& p : mesh.positions) balls.push_back({p + Vector3d(0, 0, height), std::hypot(reach, height)});
      const double gap = std::hypot(side / std::sqrt(3.0), height) - std::hypot(reach, height);
      const std::vector<CoverGap> gaps = gapsOf(mesh, balls, 1e-4);
      ASSERT_FALSE(gaps.empty());
      EXPECT_NEAR(deepest(gaps), gap, 1e-7);
      double nearest = 1;
      for (const CoverGap& g : gaps) {
        nearest = std::min(nearest, (g.point - middle).norm());
        EXPECT_NEAR(test::gapAt(g.point, balls), g.gap, 1e-12);
      }
      EXPECT_LT(nearest, 1e-6);
      EXPECT_TRUE(gapsOf(mesh, balls, 1.01 * gap).empty()) << "holes no deeper than the tolerance are left out";
    }
}

TEST(FindCoverGaps, FindsTheDeepestPlaceThatBruteForceFinds) {
  int with_holes = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const TriangleMesh mesh = test::torusMesh(5, 2, 24, 12);
    const std::vector<Ball> balls = scattered(mesh, 260, 1.3, seed);
    const double brute = test::largestGap(test::densePoints(mesh, 60, seed), balls);
    const std::vector<CoverGap> gaps = gapsOf(mesh, balls, 1e-3);
    with_holes += brute > 0.01;
    EXPECT_GE(deepest(gaps), 0.9 * brute) << "seed " << seed;
    for (const CoverGap& g : gaps) {
      EXPECT_NEAR(test::gapAt(g.point, balls), g.gap, 1e-9);
      const std::uint32_t t = g.triangle;
      EXPECT_LT(nearestOnTriangle(g.point, mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)).distance, 1e-9);
    }
    EXPECT_TRUE(std::is_sorted(gaps.begin(), gaps.end(), [](const CoverGap& a, const CoverGap& b) { return a.triangle < b.triangle; }));
  }
  EXPECT_GE(with_holes, 6);
}

TEST(FindCoverGaps, ThreeDiscsCloseATriangleAtItsCircumradiusExactly) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {1, std::sqrt(3.0), 0}};
  mesh.triangles = {{0, 1, 2}};
  for (const double off : {-1e-9, 1e-9}) {
    std::vector<Ball> balls;
    for (const Vector3d& p : mesh.positions) balls.push_back({p, 2 / std::sqrt(3.0) + off});
    const std::vector<CoverGap> gaps = gapsOf(mesh, balls, 0);
    ASSERT_EQ(gaps.empty(), off > 0);
    if (off < 0) {
      EXPECT_NEAR(deepest(gaps), -off, 1e-14);
    }
  }
}

// One triangle, balls of very different sizes about it, against a fine grid of points.
TEST(FindCoverGaps, MissesNoPlaceFartherThanTheTolerance) {
  constexpr int kGrid = 60;
  int open = 0, closed = 0;
  test::Random random(3);
  for (int trial = 0; trial < 400; ++trial) {
    TriangleMesh mesh;
    for (int k = 0; k < 3; ++k) mesh.positions.push_back(random.inCube(1));
    mesh.triangles = {{0, 1, 2}};
    std::vector<Ball> balls;
    const std::size_t count = 1 + random.below(40);
    for (std::size_t b = 0; b < count; ++b) balls.push_back({random.inCube(1.2), random.between(0.05, trial % 2 ? 0.5 : 1.2)});
    const double tolerance = trial % 3 == 0 ? 0 : random.between(0, 0.1);
    const std::vector<CoverGap> gaps = gapsOf(mesh, balls, tolerance);
    double largest = 0;
    for (int i = 0; i <= kGrid; ++i)
      for (int j = 0; i + j <= kGrid; ++j) {
        const Vector3d p = (i * mesh.positions[0] + j * mesh.positions[1] + (kGrid - i - j) * mesh.positions[2]) / kGrid;
        largest = std::max(largest, test::gapAt(p, balls));
      }
    (gaps.empty() ? closed : open)++;
    if (gaps.empty()) {
      EXPECT_LE(largest, tolerance + 1e-12) << trial;
    }
    for (const CoverGap& g : gaps) {
      EXPECT_GT(g.gap, tolerance - 1e-12) << trial;
      EXPECT_NEAR(g.gap, test::gapAt(g.point, balls), 1e-9) << trial;
      EXPECT_LT(nearestOnTriangle(g.point, mesh.positions[0], mesh.positions[1], mesh.positions[2]).distance, 1e-12) << trial;
    }
  }
  EXPECT_GE(open, 100);
  EXPECT_GE(closed, 50);
}

TEST(ProvenRedundant, TheRestCoversAndIsMinimal) {
  const TriangleMesh mesh = test::torusMesh(5, 2, 24, 12);
  Progress progress;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    CertifiedCover cover = certify(mesh, scattered(mesh, 150, 1.6, seed), 0.05);
    cover.spheres.push_back(cover.spheres[7]);  // the same ball twice: one of them is redundant
    std::vector<std::uint32_t> candidates(cover.spheres.size());
    std::iota(candidates.begin(), candidates.end(), 0u);
    const std::vector<char> redundant = provenRedundant(mesh, cover.spheres, Vector3d::Zero(), candidates, progress);
    EXPECT_TRUE(redundant[7] || redundant.back());
    std::vector<Ball> kept;
    for (std::size_t i = 0; i < redundant.size(); ++i)
      if (!redundant[i]) kept.push_back(test::toBalls({&cover.spheres[i], 1}, Vector3d::Zero()).front());
    EXPECT_LT(kept.size(), cover.spheres.size() - 10);
    EXPECT_EQ(certify(mesh, kept, 1e-5).largest_growth, 0) << "the others cover the mesh without growing";
    for (std::size_t i = 0; i < kept.size(); ++i) {
      std::vector<Ball> fewer = kept;
      fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(i));
      EXPECT_FALSE(gapsOf(mesh, fewer, 0).empty()) << "sphere " << i << " is needed";
    }
  }
}

TEST(ProvenRedundant, KeepsSpheresThatAreNotCandidates) {
  const TriangleMesh mesh = test::torusMesh(5, 2, 24, 12);
  Progress progress;
  CertifiedCover cover = certify(mesh, scattered(mesh, 60, 1.6, 1), 1e-3);
  cover.spheres.push_back(cover.spheres.front());
  const std::vector<char> none = provenRedundant(mesh, cover.spheres, Vector3d::Zero(), {}, progress);
  EXPECT_EQ(std::count(none.begin(), none.end(), 0), static_cast<std::ptrdiff_t>(cover.spheres.size()));
  const std::vector<char> one = provenRedundant(mesh, cover.spheres, Vector3d::Zero(), std::vector<std::uint32_t>{0}, progress);
  EXPECT_TRUE(one[0]);
  EXPECT_EQ(std::count(one.begin(), one.end(), 1), 1);
}

TEST(FindCoverGaps, ACoveredMeshHasNone) {
  const TriangleMesh mesh = test::torusMesh(5, 2, 24, 12);
  const CertifiedCover cover = certify(mesh, scattered(mesh, 60, 1.6, 2), 0.02);
  EXPECT_TRUE(gapsOf(mesh, test::toBalls(cover.spheres), 1e-9).empty());
}

TEST(FindCoverGaps, LooksOnlyAtTheTrianglesAsked) {
  const TriangleMesh strip = rectangle(1.4, 0.3);
  const std::vector<Ball> balls{{{-1, 0, 0}, 0.8}, {{1, 0, 0}, 0.8}};
  Progress progress;
  const std::vector<CoverGap> gaps = findCoverGaps(strip, std::vector<std::uint32_t>{1}, balls, 1e-3, progress);
  ASSERT_FALSE(gaps.empty());
  for (const CoverGap& g : gaps) EXPECT_EQ(g.triangle, 1u);
}

// Hints from earlier balls, even from a different number of balls, save time and change nothing.
TEST(FindCoverGaps, HintsFromEarlierBallsChangeNothing) {
  const TriangleMesh mesh = test::torusMesh(5, 2, 24, 12);
  std::vector<std::uint32_t> all(mesh.triangles.size());
  std::iota(all.begin(), all.end(), 0u);
  std::vector<HeldBy> held_by(mesh.triangles.size());
  for (HeldBy& balls : held_by) balls.fill(kNoBall);
  Progress progress;
  test::Random random(4);
  std::vector<Ball> balls = scattered(mesh, 120, 1.6, 3);
  int with_gaps = 0, known = 0;
  for (int round = 0; round < 30; ++round) {
    if (round == 15) balls.resize(80);
    if (round == 20) std::swap(balls[0], balls[70]);
    for (Ball& b : balls) b.centre += random.inCube(0.05), b.radius += random.between(-0.05, 0.06);
    const std::vector<CoverGap> expected = gapsOf(mesh, balls, 0.05);
    const std::vector<CoverGap> gaps = findCoverGaps(mesh, all, balls, 0.05, progress, held_by);
    ASSERT_EQ(gaps.size(), expected.size()) << round;
    for (std::size_t i = 0; i < gaps.size(); ++i) {
      EXPECT_EQ(gaps[i].point, expected[i].point);
      EXPECT_EQ(gaps[i].gap, expected[i].gap);
      EXPECT_EQ(gaps[i].triangle, expected[i].triangle);
    }
    with_gaps += !gaps.empty();
    known += held_by[round].front() != kNoBall;
  }
  EXPECT_GT(with_gaps, 20);
  EXPECT_GT(known, 10);
}

TEST(Subdivided, NoSideIsLongerAndTheSurfaceIsTheSame) {
  TriangleMesh mesh = test::boxMesh({0, 0, 0}, {7, 2, 0.01});
  mesh.positions.insert(mesh.positions.end(), {{0, 0, 5}, {9, 0, 5}, {4, 1e-9, 5}});  // a sliver
  mesh.triangles.push_back({8, 9, 10});
  const double longest = 0.8;
  const TriangleMesh cut = subdivided(mesh, longest);
  double area = 0;
  for (std::size_t t = 0; t < cut.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) EXPECT_LE((cut.corner(t, k) - cut.corner(t, (k + 1) % 3)).norm(), longest);
    area += 0.5 * (cut.corner(t, 1) - cut.corner(t, 0)).cross(cut.corner(t, 2) - cut.corner(t, 0)).norm();
  }
  EXPECT_NEAR(area, 2 * (7 * 2 + 7 * 0.01 + 2 * 0.01), 1e-6);
  EXPECT_EQ(subdivided(mesh, 100).triangles.size(), mesh.triangles.size()) << "short ones stay whole";
}

TEST(Subdivided, ASlenderTriangleTakesTwoForEachSlice) {
  TriangleMesh slender;
  slender.positions = {{0, 0, 0}, {100, 0, 0}, {100, 0.1, 0}};
  slender.triangles = {{0, 1, 2}};
  EXPECT_LE(subdivided(slender, 1).triangles.size(), 2u * 112);
}

}  // namespace
}  // namespace spheretree::builder
