// SPDX-License-Identifier: GPL-3.0-or-later
#include "molar.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "spheretree/builder/mesh_checks.h"
#include "support/sections.h"

namespace spheretree::samples {
namespace {

TEST(Molar, IsAClosedManifoldOfGenusZeroThatDoesNotCrossItself) {
  const TriangleMesh mesh = makeMolar();
  const builder::MeshReport report = builder::checkMesh(mesh);
  EXPECT_TRUE(report.clean()) << report.summary();
  EXPECT_GT(report.volume, 700);
  EXPECT_LT(report.volume, 1000);
  EXPECT_EQ(report.components.size(), 1u);
  EXPECT_EQ(mesh.positions.size() * 2 - 4, mesh.triangles.size());  // Euler: genus 0
  EXPECT_NEAR(static_cast<double>(mesh.triangles.size()), 4000, 250);
}

TEST(Molar, HasTheSizeOfATooth) {
  const builder::MeshReport report = builder::checkMesh(makeMolar());
  const Eigen::Vector3d size = report.high - report.low;
  EXPECT_NEAR(size.x(), 11, 1);
  EXPECT_NEAR(size.y(), 10, 1);
  EXPECT_NEAR(size.z(), 21, 1);
}

TEST(Molar, HasTwoRootsBelowOneTrunkBelowOneCrown) {
  const TriangleMesh mesh = makeMolar();
  EXPECT_EQ(test::outlinesAtHeight(mesh, 3.0), 1);
  EXPECT_EQ(test::outlinesAtHeight(mesh, -1.5), 1);
  EXPECT_EQ(test::outlinesAtHeight(mesh, -8.0), 2);
  EXPECT_EQ(test::outlinesAtHeight(mesh, -12.0), 2);
}

TEST(Molar, HasFiveCusps) {
  // A cusp is a vertex of the crown that is higher than all its neighbours.
  const TriangleMesh mesh = makeMolar();
  std::vector<double> highest_neighbour(mesh.positions.size(), -1e9);
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t v : t) {
      for (const std::uint32_t w : t) {
        if (w != v) highest_neighbour[v] = std::max(highest_neighbour[v], mesh.positions[w].z());
      }
    }
  }
  int cusps = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    cusps += mesh.positions[v].z() > 5 && mesh.positions[v].z() > highest_neighbour[v] ? 1 : 0;
  }
  EXPECT_EQ(cusps, 5);
}

}  // namespace
}  // namespace spheretree::samples
