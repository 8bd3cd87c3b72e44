// SPDX-License-Identifier: Apache-2.0
#include "probe_arcs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <vector>

#include "support/shape_trees.h"

namespace spheretree::runtime {
namespace {

using test::Random;

/// Leaves on and under a bumpy ball of radius 5.
std::vector<Sphere> cloud(std::uint64_t seed, int count) {
  Random random(seed);
  std::vector<Sphere> leaves;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d c = test::randomPoint(random, 1).normalized() * random.between(3, 5);
    leaves.push_back(test::ball(c.x(), c.y(), c.z(), random.between(0.8, 1.6)));
  }
  return leaves;
}

/// A square of leaves, rows and columns in order: many of their circles meet in one point.
std::vector<Sphere> grid() {
  std::vector<Sphere> leaves;
  for (int i = 0; i < 8; ++i)
    for (int j = 0; j < 8; ++j) leaves.push_back(test::ball(i, j, 0, 1));
  return leaves;
}

Eigen::Vector3d probeAt(const ProbeArcs& arcs, const Arc& arc, double angle, double probe) {
  const Leaf &a = arcs.leaves()[arc.i], &b = arcs.leaves()[arc.j];
  const double length = (b.c - a.c).norm(), ra = a.r + probe, rb = b.r + probe,
               along = (length * length + ra * ra - rb * rb) / (2 * length);
  return a.c + (b.c - a.c) / length * along + arcs.directionAt(arc, angle) * std::sqrt(ra * ra - along * along);
}

TEST(ProbeArcs, TheOutsideIsFreeOfAllLeavesAndClosed) {
  for (const double probe : {2.0, 20.0, 1e4})
    for (const std::vector<Sphere>& leaves : {cloud(1, 30), cloud(2, 150), cloud(3, 400), grid()}) {
      const ProbeArcs arcs(leaves);
      const std::vector<Arc> outside = arcs.ofTheOutside(probe);
      std::map<Triple, int> sides;
      for (const Arc& arc : outside) {
        ASSERT_NE(arc.end[0], kNone);
        for (const double part : {0.0, 0.3, 0.7, 1.0}) {
          const Eigen::Vector3d m = probeAt(arcs, arc, arc.angle[0] + part * (arc.angle[1] - arc.angle[0]), probe);
          for (std::size_t k = 0; k < leaves.size(); ++k)
            EXPECT_GT((arcs.leaves()[k].c - m).norm() - arcs.leaves()[k].r - probe, -1e-4) << probe << ' ' << leaves.size();
        }
        for (std::size_t e = 0; e < 2; ++e) {
          ++sides[arcs.tripleAt(arc, e)];
          const Leaf& third = arcs.leaves()[arc.end[e]];
          EXPECT_NEAR((third.c - probeAt(arcs, arc, arc.angle[e], probe)).norm() - third.r, probe, 1e-4);
        }
      }
      EXPECT_GT(sides.size(), 10u);
      for (const auto& [triple, count] : sides)
        EXPECT_EQ(count, 3) << triple.leaf[0] << "," << triple.leaf[1] << "," << triple.leaf[2] << " above " << triple.above << " probe "
                            << probe << ' ' << leaves.size();
    }
}

TEST(ProbeArcs, WhatIsPassedOverIsNotThere) {
  std::vector<Sphere> leaves = cloud(4, 100);
  const Sphere far = test::ball(0, 0, 9, 1);
  leaves.push_back(far);
  ProbeArcs arcs(leaves);
  const auto touches = [&] {
    int count = 0;
    for (const Arc& arc : arcs.ofTheOutside(1e3)) count += arc.i == 100 || arc.j == 100;
    return count;
  };
  EXPECT_GT(touches(), 2);
  arcs.passOver(100);
  EXPECT_EQ(touches(), 0);
  leaves.pop_back();
  EXPECT_EQ(arcs.ofTheOutside(1e3).size(), ProbeArcs(leaves).ofTheOutside(1e3).size());
}

TEST(ProbeArcs, FewLeaves) {
  EXPECT_TRUE(ProbeArcs(std::vector{test::ball(0, 0, 0, 1)}).ofTheOutside(10).empty());
  const std::vector<Arc> two = ProbeArcs(std::vector{test::ball(0, 0, 0, 1), test::ball(1, 0, 0, 1)}).ofTheOutside(10);
  ASSERT_EQ(two.size(), 1u);
  EXPECT_EQ(two[0].end[0], kNone);  // a whole circle
  EXPECT_EQ(ProbeArcs(std::vector{test::ball(0, 0, 0, 1), test::ball(1, 0, 0, 1), test::ball(0, 1, 0, 1)}).ofTheOutside(10).size(), 3u);
  EXPECT_TRUE(ProbeArcs(std::vector{test::ball(0, 0, 0, 2), test::ball(1, 0, 0, 0.5)}).ofTheOutside(10).empty());  // one in the other
}

}  // namespace
}  // namespace spheretree::runtime
