// SPDX-License-Identifier: GPL-3.0-or-later
#include "certify/redundant_spheres.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "certify/certify_cover.h"
#include "support/dense_points.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

const TriangleMesh kCube = test::boxMesh({-5, -5, -5}, {5, 5, 5});

/// One sphere about each eighth of the cube, which no other sphere covers, followed by the same spheres, slightly
/// larger.
std::vector<Sphere> twice() {
  std::vector<Sphere> spheres;
  for (const float radius : {4.4f, 4.5f})
    for (int octant = 0; octant < 8; ++octant)
      spheres.push_back({octant & 1 ? 2.5f : -2.5f, octant & 2 ? 2.5f : -2.5f, octant & 4 ? 2.5f : -2.5f, radius});
  return spheres;
}

struct Asked {
  std::vector<std::uint32_t> group = std::vector<std::uint32_t>(16, 0);
  std::vector<char> fixed{};
  std::size_t max_count = 16;
};

std::vector<char> redundantOf(const std::vector<Sphere>& spheres, const Asked& asked, const Vector3d& origin = Vector3d::Zero()) {
  TriangleMesh mesh = kCube;
  for (Vector3d& p : mesh.positions) p += origin;
  Progress progress;
  return findRedundantSpheres(mesh, spheres, origin, asked.group, asked.fixed, asked.max_count, 1, progress);
}

TEST(RedundantSpheres, OneOfTwoIsRedundantAndTheOthersStillCover) {
  for (const Vector3d& origin : {Vector3d(0, 0, 0), Vector3d(1e6, -2e6, 3e6)}) {
    const std::vector<char> redundant = redundantOf(twice(), {}, origin);
    std::vector<Sphere> kept;
    for (std::size_t i = 0; i < 8; ++i) {
      EXPECT_EQ(redundant[i] + redundant[i + 8], 1) << "eighth " << i;
      kept.push_back(twice()[redundant[i] ? i + 8 : i]);
    }
    Progress progress;
    EXPECT_EQ(certifyCover(kCube, test::toBalls(kept, Vector3d::Zero()), Vector3d::Zero(), 1e-3, progress).largest_growth, 0);
  }
}

TEST(RedundantSpheres, FindsNothingInAMinimalCover) {
  std::vector<Sphere> once = twice();
  once.resize(8);
  Asked asked;
  asked.group.resize(8);
  EXPECT_EQ(redundantOf(once, asked), std::vector<char>(8, 0));
}

TEST(RedundantSpheres, KeepsFixedSpheres) {
  Asked asked;
  asked.fixed.assign(16, 0);
  std::fill_n(asked.fixed.begin(), 8, 1);
  const std::vector<char> redundant = redundantOf(twice(), asked);
  for (std::size_t i = 0; i < 16; ++i) EXPECT_EQ(redundant[i], i >= 8) << i;
}

TEST(RedundantSpheres, TheLastOfAGroupStays) {
  Asked asked;
  for (std::uint32_t i = 0; i < 16; ++i) asked.group[i] = i;
  EXPECT_EQ(redundantOf(twice(), asked), std::vector<char>(16, 0));
}

TEST(RedundantSpheres, NoMoreThanAskedFor) {
  for (const std::size_t max_count : {0, 3, 8}) {
    Asked asked;
    asked.max_count = max_count;
    const std::vector<char> redundant = redundantOf(twice(), asked);
    EXPECT_EQ(std::count(redundant.begin(), redundant.end(), 1), static_cast<std::ptrdiff_t>(max_count));
  }
}

}  // namespace
}  // namespace spheretree::builder
