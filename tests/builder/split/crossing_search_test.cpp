// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/crossing_search.h"

#include <gtest/gtest.h>

#include "mesh/crossing_triangles.h"
#include "support/random.h"

namespace spheretree::builder {
namespace {

/// Triangles of all sizes, some of them with common corners.
TriangleMesh randomTriangles(std::uint64_t seed) {
  test::Random random(seed);
  TriangleMesh mesh;
  for (int t = 0; t < 300; ++t) {
    const double size = t % 50 == 0 ? 20 : random.between(0.1, 2);
    const Eigen::Vector3d spot(random.between(0, 10), random.between(0, 10), random.between(0, 10));
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (int k = 0; k < 3; ++k)
      mesh.positions.push_back(spot + size * Eigen::Vector3d(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)));
    mesh.triangles.push_back({first, first + 1, t % 3 == 0 && first > 0 ? first - 1 : first + 2});
  }
  return mesh;
}

TEST(CrossingSearch, FindsThePairsOfTheWholeSearchThatAreNew) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const TriangleMesh mesh = randomTriangles(seed);
    const std::size_t old = 40 * seed;
    for (const double edge : {0.02, 0.2, 30.0}) {
      CrossingSearch search(mesh.positions, edge);
      for (std::size_t t = 0; t < old; ++t) search.add(mesh.triangles[t]);
      auto expected = findCrossingTriangles(mesh, 1'000'000).pairs;
      std::erase_if(expected, [&](const auto& pair) { return pair.second < old; });
      ASSERT_GT(expected.size(), 20u);
      EXPECT_EQ(search.against({mesh.triangles.begin() + static_cast<std::ptrdiff_t>(old), mesh.triangles.end()}), expected);
    }
  }
}

}  // namespace
}  // namespace spheretree::builder
