// SPDX-License-Identifier: Apache-2.0
#include "bridge_tree.h"

#include <gtest/gtest.h>

#include <set>

#include "spheretree/runtime/scene.h"
#include "support/shape_trees.h"

namespace spheretree::runtime {
namespace {

std::vector<Sphere> randomSpheres(std::size_t count, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Sphere> spheres;
  for (std::size_t i = 0; i < count; ++i)
    spheres.push_back(test::ball(random.between(-10, 10), random.between(-10, 10), random.between(-10, 10), random.between(0.1, 1)));
  return spheres;
}

double distance(const Sphere& a, const Eigen::Vector3d& p) { return (Eigen::Vector3d(a.x, a.y, a.z) - p).norm(); }

TEST(SphereGroups, VisitsWhatTouchesTheBall) {
  for (const std::size_t count : {1u, 7u, 8u, 9u, 64u, 65u, 700u}) {
    const std::vector<Sphere> spheres = randomSpheres(count, count);
    const SphereGroups groups(spheres);
    std::set<std::uint32_t> all(groups.order().begin(), groups.order().end());
    EXPECT_EQ(all.size(), count);
    test::Random random(2);
    for (int n = 0; n < 50; ++n) {
      const Eigen::Vector3d p(random.between(-12, 12), random.between(-12, 12), random.between(-12, 12));
      const double radius = random.between(0, 4);
      std::set<std::uint32_t> expected, found;
      for (std::uint32_t i = 0; i < count; ++i)
        if (distance(spheres[i], p) <= radius + static_cast<double>(spheres[i].radius)) expected.insert(i);
      groups.visit(p, radius, [&](std::uint32_t i) { EXPECT_TRUE(found.insert(i).second) << "twice"; });
      EXPECT_EQ(found, expected);
    }
  }
}

TEST(SphereGroups, EachGroupHoldsItsEight) {
  const SphereGroups groups(randomSpheres(700, 3));
  const auto& levels = groups.levels();
  ASSERT_EQ(levels.back().size(), 1u);
  for (std::size_t level = 1; level < levels.size(); ++level)
    for (std::size_t k = 0; k < levels[level - 1].size(); ++k) {
      const Sphere &part = levels[level - 1][k], &whole = levels[level][k / 8];
      EXPECT_LE(distance(part, {whole.x, whole.y, whole.z}) + static_cast<double>(part.radius),
                static_cast<double>(whole.radius) * (1 + 1e-6));
    }
}

TEST(BridgeTree, EveryBridgeHangsUnderTheRootOnce) {
  for (const std::size_t count : {1u, 8u, 9u, 700u}) {
    const std::vector<Sphere> spheres = randomSpheres(count, count);
    std::vector<Bridge> bridges(count);
    for (std::size_t i = 0; i < count; ++i) bridges[i].radius = static_cast<float>(i + 1);  // its name
    const BridgeTree tree = treeOf(bridges, spheres);
    EXPECT_EQ(tree.count, count);
    std::multiset<float> names;
    std::vector<std::size_t> open{0};  // slots; the root is alone in block 0
    while (!open.empty()) {
      const std::size_t slot = open.back();
      open.pop_back();
      const BlockLinks& links = tree.links[slot / 8];
      if (slot % 8 >= links.inner) {
        const float name = tree.of_slot[slot].radius;
        names.insert(name);
        const Sphere& s = spheres[static_cast<std::size_t>(name) - 1];
        EXPECT_EQ(tree.bound[slot / 8].x[slot % 8], s.x);
        EXPECT_EQ(tree.bound[slot / 8].r[slot % 8], s.radius);
        continue;
      }
      const std::size_t block = links.first_child + slot % 8;
      for (std::size_t lane = 0; lane < 8; ++lane)
        if (tree.bound[block].r[lane] > 0) open.push_back(8 * block + lane);
    }
    EXPECT_EQ(names.size(), count);
    EXPECT_EQ(std::set<float>(names.begin(), names.end()).size(), count);
  }
  EXPECT_EQ(treeOf({}, {}).count, 0u);
}

}  // namespace
}  // namespace spheretree::runtime
