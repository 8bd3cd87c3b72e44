// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/box_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "geometry/distance_field.h"
#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
using Boxes = std::vector<Eigen::AlignedBox3d>;

Boxes randomBoxes(test::Random& random, std::size_t count, double size) {
  Boxes boxes;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3d low = random.inCube(1);
    boxes.emplace_back(low, low + random.inBox(Vector3d::Zero(), Vector3d::Constant(size)));
  }
  return boxes;
}

double nearestByTree(const BoxTree& tree, const Boxes& boxes, const Vector3d& p) {
  double limit2 = std::numeric_limits<double>::infinity();
  tree.searchNearest(p, limit2, [&](std::size_t first, std::size_t count) {
    for (std::size_t s = first; s < first + count; ++s) limit2 = std::min(limit2, boxes[tree.order()[s]].squaredExteriorDistance(p));
  });
  return limit2;
}

TEST(BoxTree, NearestBoxIsTheOneOfBruteForce) {
  test::Random random(1);
  for (const std::size_t count : {1, 2, 4, 5, 17, 300, 2000})
    for (const double size : {0.0, 0.05, 1.0}) {
      const Boxes boxes = randomBoxes(random, count, size);
      const BoxTree tree(boxes);
      for (int k = 0; k < 100; ++k) {
        const Vector3d p = random.inCube(2);
        double best = std::numeric_limits<double>::infinity();
        for (const auto& box : boxes) best = std::min(best, box.squaredExteriorDistance(p));
        // Boxes whose distances differ by the last bits only are equal to the search.
        EXPECT_NEAR(nearestByTree(tree, boxes, p), best, 1e-14 * best) << count << " boxes";
      }
    }
}

TEST(BoxTree, WithinVisitsEveryBoxInReachOnce) {
  test::Random random(2);
  for (const int leaf_size : {1, 4, 9}) {
    const Boxes boxes = randomBoxes(random, 700, 0.1);
    const BoxTree tree(boxes, leaf_size);
    for (int k = 0; k < 100; ++k) {
      const Vector3d p = random.inCube(1.5);
      const double radius = random.unit();
      std::vector<int> visits(boxes.size(), 0);
      tree.searchWithin(p, radius * radius, [&](std::size_t first, std::size_t count) {
        EXPECT_LE(count, static_cast<std::size_t>(leaf_size));
        for (std::size_t s = first; s < first + count; ++s) ++visits[tree.order()[s]];
      });
      for (std::size_t i = 0; i < boxes.size(); ++i) {
        EXPECT_LE(visits[i], 1);
        if (boxes[i].exteriorDistance(p) <= radius * (1 - 1e-12)) {
          EXPECT_EQ(visits[i], 1) << "box " << i;
        }
      }
    }
  }
}

// The boxes are stored in float, relative to their middle: this may lose no item at any scale and for any point.
TEST(BoxTree, LosesNoItemToRounding) {
  test::Random random(4);
  for (const double scale : {1e-200, 1e-12, 1.0, 1e9})
    for (const double offset : {0.0, 1e6})
      for (const double away : {0.5, 3.0, 9.0, 1e6, 1e25}) {
        Boxes boxes = randomBoxes(random, 200, 1e-4);
        for (auto& box : boxes) box = {scale * (box.min() + Vector3d::Constant(offset)), scale * (box.max() + Vector3d::Constant(offset))};
        const BoxTree tree(boxes);
        for (int k = 0; k < 50; ++k) {
          const Vector3d p = scale * (away * random.inCube(1) + Vector3d::Constant(offset));
          const auto& target = boxes[static_cast<std::size_t>(k)];
          const double reach2 = target.squaredExteriorDistance(p);
          double best = std::numeric_limits<double>::infinity();
          for (const auto& box : boxes) best = std::min(best, box.squaredExteriorDistance(p));
          EXPECT_NEAR(nearestByTree(tree, boxes, p), best, 1e-14 * best) << scale << " " << offset << " " << away;
          bool visited = false;
          tree.searchWithin(p, reach2, [&](std::size_t first, std::size_t count) {
            for (std::size_t s = first; s < first + count; ++s) visited = visited || tree.order()[s] == static_cast<std::uint32_t>(k);
          });
          EXPECT_TRUE(visited) << scale << " " << offset << " " << away;
        }
      }
}

using Triangles = std::vector<std::array<Vector3d, 3>>;

// In slot order of the tree that is returned with them.
struct TriangleTree {
  BoxTree tree;
  Triangles triangles;
};
TriangleTree treeOf(const Triangles& triangles, bool with_slabs) {
  Boxes boxes(triangles.size());
  for (std::size_t t = 0; t < boxes.size(); ++t)
    for (const Vector3d& corner : triangles[t]) boxes[t].extend(corner);
  TriangleTree out{BoxTree(boxes), {}};
  for (const std::uint32_t t : out.tree.order()) out.triangles.push_back(triangles[t]);
  if (with_slabs) out.tree.addTriangles(out.triangles);
  return out;
}

double nearestByTree(const TriangleTree& in, const Vector3d& p, std::size_t* tested = nullptr) {
  double nearest = std::numeric_limits<double>::infinity(), limit2 = nearest;
  in.tree.searchNearest(p, limit2, [&](std::size_t first, std::size_t count) {
    if (tested) *tested += count;
    for (std::size_t s = first; s < first + count; ++s) {
      const auto& [a, b, c] = in.triangles[s];
      nearest = std::min(nearest, nearestOnTriangle(p, a, b, c).distance);
      limit2 = nearest * nearest;
    }
  });
  return nearest;
}

// Flat patches, slivers, points: for any point and scale, the nearest triangle is that of brute force, up to the last
// bit but one.
TEST(BoxTree, SlabsLoseNoTriangleToRounding) {
  test::Random random(5);
  for (const double scale : {1e-200, 1e-12, 1.0, 1e9})
    for (const double offset : {0.0, 1e6})
      for (const double thickness : {0.0, 1e-6, 1e-2})
        for (const double away : {1e-7, 0.5, 9.0, 1e6, 1e25}) {
          const Vector3d across = random.inCube(1).normalized();
          const auto place = [&](const Vector3d& p) -> Vector3d { return scale * (p + Vector3d::Constant(offset)); };
          const auto flattened = [&](const Vector3d& p) -> Vector3d { return p - (1 - thickness) * across.dot(p) * across; };
          Triangles triangles;
          for (int t = 0; t < 200; ++t) {
            const Vector3d a = random.inCube(1), b = a + 0.1 * random.inCube(1);
            const Vector3d c = t % 3 == 0 ? b : t % 3 == 1 ? Vector3d(0.5 * (a + b)) : Vector3d(a + 0.1 * random.inCube(1));
            triangles.push_back({place(flattened(a)), place(flattened(b)), place(flattened(c))});
          }
          const TriangleTree in = treeOf(triangles, true);
          for (int k = 0; k < 20; ++k) {
            const Vector3d p = place(flattened(random.inCube(1)) + away * random.inCube(1));
            double best = std::numeric_limits<double>::infinity();
            for (const auto& [a, b, c] : triangles) best = std::min(best, nearestOnTriangle(p, a, b, c).distance);
            EXPECT_NEAR(nearestByTree(in, p), best, 1e-14 * best) << scale << " " << offset << " " << thickness << " " << away;
          }
        }
}

// Triangles that nearly touch a small ball: the nearest is decided by digits beyond the precision of float.
TEST(BoxTree, SlabsLoseNoTriangleOfManyThatAreAsNear) {
  test::Random random(6);
  for (const double radius : {1e-5, 1e-3, 1.0})
    for (int k = 0; k < 100; ++k) {
      const Vector3d p = 5 * random.inCube(1);
      Triangles triangles(2, {Vector3d(-8, -8, -8), Vector3d(-8, -8, -8), Vector3d(-8, -8, -8)});
      triangles[1].fill(Vector3d(8, 8, 8));
      double best = std::numeric_limits<double>::infinity();
      for (int t = 0; t < 100; ++t) {
        const Vector3d out = random.inCube(1).normalized(), u = 0.1 * radius * out.unitOrthogonal(), v = out.cross(u);
        const Vector3d foot = p + (radius + 1e-7 * random.unit()) * out;
        const auto& [a, b, c] = triangles.emplace_back(std::array<Vector3d, 3>{foot + u, foot - u + v, foot - u - v});
        best = std::min(best, nearestOnTriangle(p, a, b, c).distance);
      }
      EXPECT_NEAR(nearestByTree(treeOf(triangles, true), p), best, 1e-14) << radius;
    }
}

// All triangles of a ball are equally far from its middle: boxes alone exclude none of them.
TEST(BoxTree, SlabsSpareMostOfABallFromItsMiddle) {
  const TriangleMesh ball = test::sphereMesh(1, 5);
  Triangles triangles;
  for (std::size_t t = 0; t < ball.triangles.size(); ++t) triangles.push_back({ball.corner(t, 0), ball.corner(t, 1), ball.corner(t, 2)});
  const Vector3d p(0.004, 0.003, 0.002);
  std::size_t with = 0, without = 0;
  EXPECT_EQ(nearestByTree(treeOf(triangles, true), p, &with), nearestByTree(treeOf(triangles, false), p, &without));
  EXPECT_LT(with, without / 5);
  EXPECT_GT(without, triangles.size() / 2);
}

// Of the 18 triangles in the boxes that a point halfway inside a ball meets, four have to be examined.
TEST(BoxTree, PrismsSpareMostTrianglesOfALeaf) {
  const TriangleMesh ball = test::sphereMesh(1, 5);
  Triangles triangles;
  for (std::size_t t = 0; t < ball.triangles.size(); ++t) triangles.push_back({ball.corner(t, 0), ball.corner(t, 1), ball.corner(t, 2)});
  const TriangleTree in = treeOf(triangles, true);
  test::Random random(8);
  std::size_t met = 0, tested = 0;
  for (int k = 0; k < 100; ++k) {
    const Vector3d p = 0.5 * random.inCube(1).normalized();
    double limit2 = std::numeric_limits<double>::infinity();
    met += in.tree.searchNearest(p, limit2, [&](std::size_t first, std::size_t count) {
      tested += count;
      for (std::size_t s = first; s < first + count; ++s) {
        const auto& [a, b, c] = in.triangles[s];
        const double distance = nearestOnTriangle(p, a, b, c).distance;
        limit2 = std::min(limit2, distance * distance);
      }
    });
  }
  EXPECT_LT(tested, met / 3);
  EXPECT_GE(tested, 100u);
}

TEST(BoxTree, OrderIsAPermutation) {
  test::Random random(3);
  const BoxTree tree(randomBoxes(random, 1000, 0.2));
  EXPECT_EQ(std::set<std::uint32_t>(tree.order().begin(), tree.order().end()).size(), 1000u);
}

TEST(BoxTree, EmptyTreeFindsNothing) {
  const BoxTree tree{Boxes{}};
  double limit2 = 1;
  tree.searchNearest(Vector3d::Zero(), limit2, [](std::size_t, std::size_t) { FAIL(); });
  tree.searchWithin(Vector3d::Zero(), 1, [](std::size_t, std::size_t) { FAIL(); });
}

// Without a bound on the depth, such inputs would overflow the stack of a search.
TEST(BoxTree, EqualAndEverSmallerBoxesStaySearchable) {
  Boxes equal(20000, Eigen::AlignedBox3d(Vector3d::Zero(), Vector3d::Ones()));
  EXPECT_EQ(nearestByTree(BoxTree(equal), equal, Vector3d(2, 0, 0)), 1);
  Boxes shrinking;
  for (int i = 0; i < 1000; ++i) {
    const Vector3d p(std::ldexp(1.0, -i), 0, 0);
    shrinking.emplace_back(p, p);
  }
  const BoxTree tree(shrinking, 1);
  EXPECT_EQ(nearestByTree(tree, shrinking, Vector3d(-1, 0, 0)), 1);
  EXPECT_EQ(nearestByTree(tree, shrinking, Vector3d(2, 0, 0)), 1);
}

}  // namespace
}  // namespace spheretree::builder
