// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/initial_clusters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "support/regions.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

TEST(InitialClusters, EachPointLiesInTheBallThatItIsDeepestIn) {
  const test::WholeRegion whole(test::torusMesh(5, 1, 40, 16), 300);
  const Region region = whole.region(8);
  std::size_t points = 0;
  for (const MedialCluster& c : startClusters(region)) {
    EXPECT_FALSE(c.points.empty());
    points += c.points.size();
    for (const Vector3d& p : c.points) {
      double smallest = std::numeric_limits<double>::infinity();
      for (const FittedBall& b : region.pool) smallest = std::min(smallest, (p - b.centre).norm() - b.clearance);
      EXPECT_NEAR((p - c.ball.centre).norm() - c.ball.clearance, smallest, 1e-12);
      EXPECT_LE((p - c.ball.centre).norm(), c.ball.radius * (1 + 1e-12));
    }
  }
  EXPECT_EQ(points, region.points.size());
}

TEST(InitialClusters, NeighboursAreMutual) {
  const test::WholeRegion whole(test::boxMesh({-1, -2, -3}, {1, 2, 3}), 300);
  const std::vector<MedialCluster> clusters = startClusters(whole.region(8));
  std::size_t links = 0;
  for (std::uint32_t c = 0; c < clusters.size(); ++c) {
    EXPECT_TRUE(std::is_sorted(clusters[c].neighbours.begin(), clusters[c].neighbours.end()));
    for (const std::uint32_t n : clusters[c].neighbours) {
      ++links;
      EXPECT_NE(n, c);
      EXPECT_TRUE(std::binary_search(clusters[n].neighbours.begin(), clusters[n].neighbours.end(), c));
    }
  }
  EXPECT_GT(links, clusters.size());
}

// A rule whose price of a merge is the number of points must merge the smallest clusters first.
TEST(InitialClusters, MergesTheCheapestPairFirst) {
  const test::WholeRegion whole(test::boxMesh({-1, -2, -3}, {1, 2, 3}), 400);
  const MergeRule by_count = [](const Region&, const MedialCluster& a, const MedialCluster& b, std::vector<Vector3d>&) {
    return FittedBall{a.ball.centre, static_cast<double>(a.points.size() + b.points.size()), 0};
  };
  const std::vector<FittedBall> balls = mergeClusters(whole.region(8), startClusters(whole.region(8)), by_count);
  ASSERT_EQ(balls.size(), 8u);
  double smallest = std::numeric_limits<double>::infinity(), largest = 0, sum = 0;
  for (const FittedBall& b : balls) smallest = std::min(smallest, b.radius), largest = std::max(largest, b.radius), sum += b.radius;
  EXPECT_EQ(sum, static_cast<double>(whole.points.size()));
  EXPECT_LE(largest, 5 * smallest);
}

}  // namespace
}  // namespace spheretree::builder
