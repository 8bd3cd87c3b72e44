// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/reachable_space.h"

#include <gtest/gtest.h>

#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

// A ball half buried in a block: the part outside is reached, the part inside is not.
TEST(ReachableSpace, EndsWhereOneSolidEntersAnother) {
  const TriangleMesh block = test::boxMesh({-10, -10, -10}, {10, 10, 0}), ball = test::sphereMesh(4, 4);
  Progress progress;
  const std::vector<TriangleMesh> solids{block, ball};
  const ReachableSpace space(solids, 0.3, progress);
  const std::vector<char> reached = space.reached(ball);
  const double unsure = 0.3 + 3 * space.cell();
  int out = 0, in = 0;
  for (std::size_t t = 0; t < reached.size(); ++t) {
    const double low = std::min({ball.corner(t, 0).z(), ball.corner(t, 1).z(), ball.corner(t, 2).z()});
    const double high = std::max({ball.corner(t, 0).z(), ball.corner(t, 1).z(), ball.corner(t, 2).z()});
    if (low > 0) {
      EXPECT_TRUE(reached[t]);
      ++out;
    } else if (high < -unsure) {
      EXPECT_FALSE(reached[t]);
      ++in;
    }
  }
  EXPECT_GT(out, 100);
  EXPECT_GT(in, 100);
}

// A slot between two blocks: a ball that fits enters, a ball that is too thick by some cells does not.
TEST(ReachableSpace, ExcludesSlotsThinnerThanTheBall) {
  const TriangleMesh left = test::boxMesh({-11, -10, -10}, {-1, 10, 10}), right = test::boxMesh({1, -10, -10}, {11, 10, 10});
  Progress progress;
  const std::vector<TriangleMesh> solids{left, right};
  const auto wallReached = [&](double radius) {
    const std::vector<char> reached = ReachableSpace(solids, radius, progress).reached(left);
    for (std::size_t t = 0; t < reached.size(); ++t)
      if (left.corner(t, 0).x() == -1 && left.corner(t, 1).x() == -1 && left.corner(t, 2).x() == -1 && reached[t]) return true;
    return false;
  };
  EXPECT_TRUE(wallReached(0.4));
  EXPECT_TRUE(wallReached(0.99));
  // The walls are two triangles each, so that their edges are always touched from outside; the middle of the slot
  // decides.
  TriangleMesh spot;
  spot.positions = {{-1, -1, -1}, {-1, 1, -1}, {-1, 0, 1}};
  spot.triangles = {{0, 1, 2}};
  EXPECT_EQ(ReachableSpace(solids, 0.9, progress).reached(spot)[0], 1);
  EXPECT_EQ(ReachableSpace(solids, 2.5, progress).reached(spot)[0], 0);
}

TEST(ReachableSpace, DoesNotEnterAClosedHollow) {
  TriangleMesh shell = test::sphereMesh(10, 3);
  const TriangleMesh hollow = test::sphereMesh(7, 3);
  const auto first = static_cast<std::uint32_t>(shell.positions.size());
  shell.positions.insert(shell.positions.end(), hollow.positions.begin(), hollow.positions.end());
  for (const Triangle& t : hollow.triangles) shell.triangles.push_back({t[0] + first, t[2] + first, t[1] + first});
  Progress progress;
  const std::vector<char> reached = ReachableSpace({&shell, 1}, 0.5, progress).reached(shell);
  for (std::size_t t = 0; t < reached.size(); ++t) EXPECT_EQ(reached[t] != 0, shell.triangles[t][0] < first);
}

}  // namespace
}  // namespace spheretree::builder
