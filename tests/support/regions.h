// SPDX-License-Identifier: GPL-3.0-or-later
// Regions of a mesh for the tests of the reducers, and the promises of every reducer.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "geometry/surface_samples.h"
#include "medial/shrinking_balls.h"
#include "published/region_reducer.h"
#include "support/shapes.h"

namespace spheretree::test {

/// A whole mesh as one region: samples of its surface, and the inner balls that touch there.
struct WholeRegion {
  builder::DistanceField field;
  std::vector<Eigen::Vector3d> points;
  std::vector<builder::FittedBall> pool;

  WholeRegion(const TriangleMesh& mesh, std::size_t count) : field(mesh) {
    builder::SampleSettings settings;
    settings.count = count;
    for (const builder::SurfaceSample& s : builder::sampleSurface(mesh, settings)) {
      points.push_back(s.point);
      if (s.feature) continue;
      const Ball ball = builder::shrinkingBall(field, s.point, s.normal);
      if (ball.radius > 0) pool.push_back({ball.centre, ball.radius, ball.radius});
    }
  }
  builder::Region region(std::size_t max_count) const {
    builder::Region region{field, points, pool};
    region.max_balls = max_count;
    return region;
  }
  using Ball = builder::Ball;
};

using builder::worstOverhang;

/// Share of the region's points that lie in no ball.
inline double openShare(const builder::Region& region, const std::vector<builder::FittedBall>& balls) {
  std::size_t open = 0;
  for (const Eigen::Vector3d& p : region.points) {
    bool held = false;
    for (const builder::FittedBall& b : balls) held = held || (p - b.centre).norm() <= b.radius * (1 + 1e-6);
    open += !held;
  }
  return static_cast<double>(open) / static_cast<double>(region.points.size());
}

/// Properties of every reducer: few balls, correct clearances, no side effects, fewer balls where fewer suffice.
/// `open`: share of the points that the method may leave to the caller (it examines a selection of them).
inline void expectReduces(builder::Reducer reduce, double open = 0) {
  for (const TriangleMesh& mesh : {boxMesh({-1, -2, -3}, {1, 2, 3}), torusMesh(5, 1, 40, 16), sphereMesh(2, 3)}) {
    const WholeRegion whole(mesh, 600);
    double before = std::numeric_limits<double>::infinity();
    for (const std::size_t max_count : {1, 3, 8}) {
      SCOPED_TRACE(std::to_string(mesh.triangles.size()) + " triangles, at most " + std::to_string(max_count));
      const builder::Region region = whole.region(max_count);
      const std::vector<builder::FittedBall> balls = reduce(region);
      ASSERT_FALSE(balls.empty());
      EXPECT_LE(balls.size(), max_count);
      EXPECT_LE(openShare(region, balls), open);
      for (const builder::FittedBall& b : balls) EXPECT_NEAR(b.clearance, -whole.field.signedDistance(b.centre), 1e-9);
      const std::vector<builder::FittedBall> again = reduce(region);
      ASSERT_EQ(again.size(), balls.size());
      for (std::size_t i = 0; i < balls.size(); ++i) {
        EXPECT_EQ(again[i].centre, balls[i].centre);
        EXPECT_EQ(again[i].radius, balls[i].radius);
      }
      before = std::min(before, worstOverhang(balls));
      builder::Region easy = whole.region(max_count);
      easy.target_overhang = 2 * whole.field.diagonal();
      EXPECT_EQ(reduce(easy).size(), 1u);
    }
    // Eight balls must be better than one ball around everything, unless the object is a ball.
    if (mesh.positions.size() != sphereMesh(2, 3).positions.size()) {
      EXPECT_LT(before, 0.8 * worstOverhang(reduce(whole.region(1))));
    }
  }
}

}  // namespace spheretree::test
