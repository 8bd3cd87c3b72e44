// SPDX-License-Identifier: GPL-3.0-or-later
#include "cut/cut_volumes.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <vector>

#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
constexpr double kPi = std::numbers::pi;

std::vector<DistanceField> fields(std::initializer_list<TriangleMesh> meshes) {
  std::vector<DistanceField> out;
  for (const TriangleMesh& mesh : meshes) out.emplace_back(mesh);
  return out;
}

/// Volumes of a scene whose truth is known.
void expectTruth(LayerFields layers, std::span<const BurrPath> paths, const std::vector<double>& truth, double share = 0.005) {
  Progress progress;
  double whole = 0;
  for (const double volume : truth) whole += volume;
  const CutVolumes found = removedVolumes(layers, paths, {.tolerance = share * whole}, progress);
  EXPECT_TRUE(found.is_met);
  double width = 0;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    EXPECT_LE(found.layers[k].low, truth[k] * (1 + 1e-12)) << k;
    EXPECT_GE(found.layers[k].high, truth[k] * (1 - 1e-12)) << k;
    width += found.layers[k].width();
  }
  EXPECT_LE(width, share * whole);
  EXPECT_LE(found.total.low, whole * (1 + 1e-12));
  EXPECT_GE(found.total.high, whole * (1 - 1e-12));
}

double ballVolume(double r) { return 4 * kPi / 3 * r * r * r; }
/// Of a ball whose centre is `height` above a plane, the part below it (Archimedes).
double capVolume(double r, double height) { return kPi / 3 * (r - height) * (r - height) * (2 * r + height); }

BurrPath ball(const Vector3d& centre, double radius) { return {radius, {centre, centre}}; }

TEST(CutVolumes, ACapHasTheVolumeOfArchimedes) {
  const auto block = fields({test::boxMesh({-3, -3, -3}, {3, 3, 0})});
  for (const double height : {-0.6, -0.49, 0.0, 0.3, 0.49}) {
    const double truth = height < -0.5 ? ballVolume(0.5) : capVolume(0.5, height);
    expectTruth(block, std::array{ball({0.123, -0.4, height}, 0.5)}, {truth}, height < 0.4 ? 0.005 : 0.05);  // a thin cap is mostly border
  }
}

TEST(CutVolumes, TwoBallsHaveTheirLensOnce) {
  const auto block = fields({test::boxMesh({-3, -3, -3}, {3, 3, 3})});
  for (const double apart : {0.01, 0.3, 0.7, 0.99}) {
    const double r = 0.5, lens = kPi / 12 * (4 * r + apart) * (2 * r - apart) * (2 * r - apart);
    const Vector3d way = Vector3d(1, 2, -0.7).normalized() * apart;
    expectTruth(block, std::array{ball({0.1, 0.2, 0.3}, r), ball(Vector3d(0.1, 0.2, 0.3) + way, r)}, {2 * ballVolume(r) - lens});
  }
}

TEST(CutVolumes, ACapsuleAndACylinderHaveTheirVolumes) {
  const auto block = fields({test::boxMesh({-4, -4, -4}, {4, 4, 4})});
  expectTruth(block, std::array{BurrPath{0.4, {{-1, -1, 0}, {1, 0.5, 0.7}}}},
              {ballVolume(0.4) + kPi * 0.16 * Vector3d(2, 1.5, 0.7).norm()});
  const auto plate = fields({test::boxMesh({-4, -4, -0.5}, {4, 4, 0.7})});  // drilled through
  expectTruth(plate, std::array{BurrPath{0.4, {{0.3, 0.2, -3}, {0.3, 0.2, 3}}}}, {kPi * 0.16 * 1.2});
}

TEST(CutVolumes, EachLayerHasItsShare) {
  const auto block = fields(
      {test::boxMesh({-4, -4, -4}, {4, 4, 0}), test::boxMesh({-3, -3, -3}, {3, 3, -0.5}), test::boxMesh({-1, -1, -2.5}, {1, 1, -1.5})});
  // A hole from above that ends in the third layer: a cylinder and a half ball.
  expectTruth(block, std::array{BurrPath{0.3, {{0.1, 0, 2}, {0.1, 0, -1.9}}}},
              {kPi * 0.09 * 0.5, kPi * 0.09 * 1.0, kPi * 0.09 * 0.4 + ballVolume(0.3) / 2});
}

/// A raster of many short, uneven steps; the truth is that of the rectangle that it fills, to be known without overlap.
TEST(CutVolumes, ManyUnevenStepsAreOnePath) {
  test::Random random(3);
  const auto block = fields({test::boxMesh({-4, -4, -4}, {4, 4, 4})});
  BurrPath path{0.5, {}};
  for (int i = 0; i <= 3000; ++i) path.centres.push_back({-1.5 + 3.0 * i / 3000, 0, 0});
  for (std::size_t i = 1; i + 1 < path.centres.size(); ++i) path.centres[i].x() += random.between(-4e-4, 4e-4);
  expectTruth(block, std::array{path}, {ballVolume(0.5) + kPi * 0.25 * 3});
  EXPECT_LT(sweptCapsules(std::array{path}, 5e-5).size(), 50u);
  EXPECT_EQ(sweptCapsules(std::array{path}, 0).size(), 3000u);
}

TEST(CutVolumes, ContainTheTruthOnRandomPaths) {
  test::Random random(57);
  const auto block = fields({test::boxMesh({0, 0, 0}, {12, 12, 3}), test::boxMesh({0.5, 0.5, 0.5}, {11.5, 11.5, 2})});
  const int runs = std::getenv("SPHERETREE_LONG") ? 60 : 20;
  for (int run = 0; run < runs; ++run) {
    std::vector<BurrPath> paths;
    std::vector<double> truth{0, 0};
    for (int x = 0; x < 3; ++x)
      for (int y = 0; y < 3; ++y) {  // far apart, each of its own kind
        const double r = random.between(0.2, 0.7);
        const Vector3d at(2 + 4 * x + random.between(-0.5, 0.5), 2 + 4 * y + random.between(-0.5, 0.5), 0);
        const double depth = random.between(0, 0.9) * r;
        if (random.below(2) == 0) {  // a cap of the surface, in the outer layer alone
          paths.push_back(ball(at + Vector3d(0, 0, 3 + depth), r));
          truth[0] += capVolume(r, depth);
        } else {  // a hole through all
          paths.push_back({r, {at + Vector3d(0, 0, 5), at + Vector3d(0, 0, random.between(0.6, 1.9)), at - Vector3d(0, 0, 2)}});
          truth[0] += kPi * r * r * 1.5;
          truth[1] += kPi * r * r * 1.5;
        }
      }
    expectTruth(block, paths, truth, 0.02);
  }
}

TEST(CutVolumes, RefinesAMeshWithManyTriangles) {
  const TriangleMesh sphere = test::sphereMesh(2, 4);
  const auto ball_of_mesh = fields({sphere});
  // A burr that sweeps all of it removes exactly its volume.
  expectTruth(ball_of_mesh, std::array{BurrPath{4, {{0, 0, -0.5}, {0, 0, 0.5}}}}, {ball_of_mesh[0].volume()});
}

TEST(CutVolumes, NothingIsRemovedOutsideOfTheObject) {
  Progress progress;
  const auto block = fields({test::boxMesh({0, 0, 0}, {1, 1, 1}), test::boxMesh({0.2, 0.2, 0.2}, {0.8, 0.8, 0.8})});
  for (const std::vector<BurrPath>& paths : {std::vector<BurrPath>{}, {BurrPath{0.3, {{3, 3, 3}, {4, 4, 4}}}}}) {
    const CutVolumes found = removedVolumes(block, paths, {}, progress);
    EXPECT_TRUE(found.is_met);
    EXPECT_EQ(found.total.high, 0);
    EXPECT_EQ(found.layers[1].high, 0);
  }
}

TEST(CutVolumes, GivesTheSameBytesForAnyThreadsAndSaysIfItStops) {
  const auto block = fields({test::boxMesh({-4, -4, -4}, {4, 4, 0}), test::sphereMesh(2, 3)});
  const std::array paths{BurrPath{0.5, {{-1, 0.2, 0}, {0, 0, -1}, {1, -0.3, -0.4}}}};
  std::vector<CutVolumes> found;
  for (const std::size_t threads : {1, 2, 5}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    Progress progress;
    found.push_back(removedVolumes(block, paths, {}, progress));
  }
  for (const CutVolumes& other : found)
    for (std::size_t k = 0; k < 2; ++k) {
      EXPECT_EQ(other.layers[k].low, found[0].layers[k].low);
      EXPECT_EQ(other.layers[k].high, found[0].layers[k].high);
    }
  Progress progress;
  const CutVolumes stopped = removedVolumes(block, paths, {.tolerance = 1e-9, .max_cells = 2000}, progress);
  EXPECT_FALSE(stopped.is_met);
  EXPECT_LE(stopped.total.low, found[0].total.low + found[0].total.width());
  EXPECT_GE(stopped.total.high, found[0].total.high - found[0].total.width());
}

}  // namespace
}  // namespace spheretree::builder
