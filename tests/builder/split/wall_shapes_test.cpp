// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/wall_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "support/mesh_measures.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

constexpr std::uint32_t kCorners = 24;

/// A regular polygon of radius 2 in the plane z = 0, clockwise as seen from above.
std::vector<std::uint32_t> clockwiseRim(TriangleMesh& mesh) {
  std::vector<std::uint32_t> loop;
  for (std::uint32_t i = 0; i < kCorners; ++i) {
    const double angle = -2 * M_PI * i / kCorners;
    loop.push_back(static_cast<std::uint32_t>(mesh.positions.size()));
    mesh.positions.emplace_back(2 * std::cos(angle), 2 * std::sin(angle), 0);
  }
  return loop;
}

const double kPolygonArea = kCorners * 2 * std::sin(2 * M_PI / kCorners);

TEST(WallShapes, ASpanFillsTheLoopWithoutFurtherVertices) {
  TriangleMesh mesh;
  const std::vector<std::uint32_t> loop = clockwiseRim(mesh);
  mesh.triangles = spanWall(mesh, loop);
  EXPECT_EQ(mesh.triangles.size(), kCorners - 2);
  EXPECT_EQ(mesh.positions.size(), kCorners);
  EXPECT_NEAR(test::areaOf(mesh), kPolygonArea, 1e-9);
  EXPECT_TRUE(spanWall(mesh, {loop[0], loop[1]}).empty());
}

TEST(WallShapes, ACollarJoinsItsTwoLoopsAndLeavesStillVertices) {
  for (const std::uint32_t still : {0u, 5u}) {
    TriangleMesh mesh;
    WallRim rim{clockwiseRim(mesh), std::vector<char>(kCorners, 0)};
    std::fill_n(rim.is_still.begin(), still, char{1});
    const std::vector<Vector3d> normals(kCorners, Vector3d::UnitZ());
    const Collar collar = addCollar(mesh, rim, 0.5, 0.5, normals, Vector3d::UnitX());
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> balance;
    for (const Triangle& t : collar.triangles)
      for (std::size_t k = 0; k < 3; ++k) {
        ++balance[{t[k], t[(k + 1) % 3]}];
        --balance[{t[(k + 1) % 3], t[k]}];
      }
    for (std::uint32_t i = 0; i < kCorners; ++i) {
      const std::uint32_t j = (i + 1) % kCorners;
      const bool is_open = !rim.is_still[i] || !rim.is_still[j];
      EXPECT_EQ((balance[{rim.loop[i], rim.loop[j]}]), is_open);
      EXPECT_EQ((balance[{collar.inner[j], collar.inner[i]}]), is_open);
      EXPECT_NEAR(mesh.positions[collar.inner[i]].z(), rim.is_still[i] ? 0 : -0.5, 1e-12);
    }
  }
}

TEST(WallShapes, AStubHasTheVolumeOfACutCone) {
  TriangleMesh mesh;
  const std::vector<std::uint32_t> loop = clockwiseRim(mesh);
  mesh.triangles = addStub(mesh, loop, 6, Vector3d::UnitZ());
  for (std::uint32_t i = 1; i + 1 < kCorners; ++i) mesh.triangles.push_back({loop[0], loop[i + 1], loop[i]});  // the lid
  EXPECT_NEAR(test::volumeOf(mesh), 6 * kPolygonArea * (1 + 0.4 + 0.4 * 0.4) / 3, 1e-9);
}

}  // namespace
}  // namespace spheretree::builder
