// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/hull_cover.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/smooth_shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

// A cylinder of 1 mm and 10 mm length in two cones that share the ball at its middle.
std::vector<Hull> twoCones(double radius) {
  const auto at = [&](double z) { return Ball{{0, 0, z}, radius}; };
  return {{{at(-0.5), at(5), {}}, 2}, {{at(5), at(10.5), {}}, 2}};
}

TEST(HullCover, OverlappingConesCoverACylinder) {
  const TriangleMesh mesh = test::cylinderMesh(1, 10, 32, 7);
  Progress progress;
  EXPECT_TRUE(provenCovered(mesh, twoCones(1.01), Vector3d::Zero(), progress));
  EXPECT_TRUE(provenCovered(mesh, twoCones(1.0001), Vector3d::Zero(), progress));
}

TEST(HullCover, FindsWhatIsBare) {
  const TriangleMesh mesh = test::cylinderMesh(1, 10, 32, 7);
  Progress progress;
  EXPECT_FALSE(provenCovered(mesh, twoCones(0.99), Vector3d::Zero(), progress)) << "the corners are bare";
  const std::vector<Hull> both = twoCones(1.01);
  EXPECT_FALSE(provenCovered(mesh, std::vector<Hull>{both[0]}, Vector3d::Zero(), progress)) << "half of it is bare";
  EXPECT_FALSE(provenCovered(mesh, {}, Vector3d::Zero(), progress));
  std::vector<Hull> apart = both;
  apart[1].ball[0].centre.z() += 2.2;  // a ring of 0.2 mm less the caps
  EXPECT_FALSE(provenCovered(mesh, apart, Vector3d::Zero(), progress));
}

TEST(HullCover, AHullMayBeOmitted) {
  const std::vector<Hull> both = twoCones(1.01);
  const HullCover cover(both, 1e-9);
  const Piece low{{Vector3d(1, 0, 1), Vector3d(0, 1, 1), Vector3d(0, 1, 2)}};
  EXPECT_TRUE(cover.holds(low));
  EXPECT_TRUE(cover.holds(low, 1));
  EXPECT_FALSE(cover.holds(low, 0));
}

}  // namespace
}  // namespace spheretree::builder
