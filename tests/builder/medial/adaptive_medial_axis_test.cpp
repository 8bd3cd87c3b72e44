// SPDX-License-Identifier: GPL-3.0-or-later
#include "medial/adaptive_medial_axis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "geometry/surface_samples.h"
#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

std::vector<Vector3d> sitesOf(const TriangleMesh& mesh, std::size_t count) {
  SampleSettings settings;
  settings.count = count;
  std::vector<Vector3d> sites;
  for (const SurfaceSample& s : sampleSurface(mesh, settings)) sites.push_back(s.point);
  return sites;
}

std::uint32_t everywhere(const Vector3d&) { return 0; }

double worst(const std::vector<FittedBall>& balls) {
  double largest = 0;
  for (const FittedBall& b : balls) largest = std::max(largest, b.radius - b.clearance);
  return largest;
}

TEST(AdaptiveMedialAxis, BallsAreInsideAndClearancesTrue) {
  for (const TriangleMesh& mesh : {test::boxMesh({-1, -2, -3}, {1, 2, 3}), test::torusMesh(5, 1, 30, 12)}) {
    const DistanceField field(mesh);
    AdaptiveMedialAxis axis(field, sitesOf(mesh, 150));
    Progress progress;
    const std::vector<AdaptiveMedialAxis::Target> targets{{0.2, 100, 200}};
    const auto balls = axis.refine(everywhere, targets, progress);
    ASSERT_EQ(balls.size(), 1u);
    EXPECT_GE(balls[0].size(), 100u);
    for (const FittedBall& b : balls[0]) {
      EXPECT_NEAR(b.clearance, -field.signedDistance(b.centre), 1e-9);
      EXPECT_GT(b.clearance, 0);
      EXPECT_GE(b.radius, b.clearance);
    }
  }
}

TEST(AdaptiveMedialAxis, RefinementLowersTheWorstOverhangToTheTarget) {
  const TriangleMesh mesh = test::boxMesh({-1, -2, -3}, {1, 2, 3});
  const DistanceField field(mesh);
  AdaptiveMedialAxis axis(field, sitesOf(mesh, 60));
  Progress progress;
  const double before = worst(axis.refine(everywhere, std::vector<AdaptiveMedialAxis::Target>{{0, 0, 0}}, progress)[0]);
  const std::size_t sites = axis.siteCount();
  const double after = worst(axis.refine(everywhere, std::vector<AdaptiveMedialAxis::Target>{{0.05, 0, 5000}}, progress)[0]);
  EXPECT_GT(before, 0.2);
  EXPECT_LE(after, 0.05);
  EXPECT_GT(axis.siteCount(), sites);
  EXPECT_LT(axis.siteCount(), sites + 5000);
}

TEST(AdaptiveMedialAxis, OnlyTheRegionIsRefined) {
  const TriangleMesh mesh = test::boxMesh({-10, -1, -1}, {10, 1, 1});
  const DistanceField field(mesh);
  AdaptiveMedialAxis axis(field, sitesOf(mesh, 200));
  Progress progress;
  const auto half = [](const Vector3d& p) { return p.x() < 0 ? 0u : 1u; };
  const std::vector<AdaptiveMedialAxis::Target> targets{{0.05, 0, 2000}, {1e9, 0, 2000}};
  const auto balls = axis.refine(half, targets, progress);
  EXPECT_LE(worst(balls[0]), 0.05);
  EXPECT_GT(worst(balls[1]), 0.1);
}

// Many sites of a grid are cospherical: predicates must not fail, and equal centres count once.
TEST(AdaptiveMedialAxis, CosphericalSites) {
  const TriangleMesh mesh = test::boxMesh({0, 0, 0}, {4, 4, 4});
  std::vector<Vector3d> grid;
  for (int x = 0; x <= 8; ++x)
    for (int y = 0; y <= 8; ++y)
      for (int z = 0; z <= 8; ++z)
        if (x % 8 == 0 || y % 8 == 0 || z % 8 == 0) grid.emplace_back(0.5 * x, 0.5 * y, 0.5 * z);
  grid.insert(grid.end(), grid.begin(), grid.begin() + 20);  // repeated sites
  const DistanceField field(mesh);
  AdaptiveMedialAxis axis(field, grid);
  EXPECT_EQ(axis.siteCount(), 386u);
  Progress progress;
  const auto balls = axis.refine(everywhere, std::vector<AdaptiveMedialAxis::Target>{{0, 0, 0}}, progress);
  EXPECT_LT(balls[0].size(), axis.ballCount() / 2);
  for (std::size_t i = 0; i < balls[0].size(); ++i)
    for (std::size_t j = 0; j < i; ++j) EXPECT_GT((balls[0][i].centre - balls[0][j].centre).norm(), 1e-9);
}

// A plate far thinner than the distance between the sites has hardly any Voronoi vertices inside: every site still gets
// its ball.
TEST(AdaptiveMedialAxis, SitesWithoutAVertexInsideGetTheirInnerBall) {
  const TriangleMesh mesh = test::boxMesh({0, 0, 0}, {1, 1, 0.01});
  const DistanceField field(mesh);
  AdaptiveMedialAxis axis(field, sitesOf(mesh, 100));
  Progress progress;
  const auto balls = axis.refine(everywhere, std::vector<AdaptiveMedialAxis::Target>{{0, 0, 0}}, progress);
  EXPECT_GT(balls[0].size(), 80u);
  for (const FittedBall& b : balls[0]) EXPECT_NEAR(b.clearance, -field.signedDistance(b.centre), 1e-9);
}

TEST(AdaptiveMedialAxis, FewOrFlatSites) {
  const TriangleMesh mesh = test::boxMesh({0, 0, 0}, {1, 1, 1});
  const DistanceField field(mesh);
  Progress progress;
  for (const std::vector<Vector3d>& sites :
       {std::vector<Vector3d>{}, std::vector<Vector3d>{{0.5, 0.5, 0}},
        std::vector<Vector3d>{{0.1, 0.1, 0}, {0.9, 0.1, 0}, {0.9, 0.9, 0}, {0.1, 0.9, 0}, {0.5, 0.5, 0}}}) {
    AdaptiveMedialAxis axis(field, sites);
    const auto balls = axis.refine(everywhere, std::vector<AdaptiveMedialAxis::Target>{{0.1, 10, 10}}, progress);
    EXPECT_EQ(balls[0].size(), sites.size());  // only inner balls
  }
}

}  // namespace
}  // namespace spheretree::builder
