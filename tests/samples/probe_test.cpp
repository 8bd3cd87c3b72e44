// SPDX-License-Identifier: GPL-3.0-or-later
#include "probe.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "spheretree/builder/mesh_checks.h"
#include "support/sections.h"

namespace spheretree::samples {
namespace {

TEST(Probe, IsAClosedManifoldOfGenusZeroThatDoesNotCrossItself) {
  const TriangleMesh mesh = makeProbe();
  const builder::MeshReport report = builder::checkMesh(mesh);
  EXPECT_TRUE(report.clean()) << report.summary();
  EXPECT_GT(report.volume, 0);
  EXPECT_EQ(report.components.size(), 1u);
  EXPECT_EQ(mesh.triangles.size(), 1088u);
  EXPECT_EQ(mesh.positions.size() * 2 - 4, mesh.triangles.size());  // Euler: genus 0
}

TEST(Probe, HasItsTipAtTheOriginAndItsShaftAlongZ) {
  const TriangleMesh mesh = makeProbe();
  double lowest_shaft = 1e9, highest = -1e9, nearest = 1e9;
  for (const Eigen::Vector3d& p : mesh.positions) {
    highest = std::max(highest, p.z());
    nearest = std::min(nearest, p.norm());
    if (p.z() > 13.5) lowest_shaft = std::min(lowest_shaft, (p - Eigen::Vector3d(3.5, 0, p.z())).norm());
  }
  EXPECT_EQ(nearest, 0);
  EXPECT_DOUBLE_EQ(highest, 34);
  EXPECT_LE(lowest_shaft, 1.2);
  EXPECT_EQ(test::outlinesAtHeight(mesh, 25), 1);
}

TEST(Probe, TapersToAFineTip) {
  double widest_near_tip = 0, widest = 0;
  for (const Eigen::Vector3d& p : makeProbe().positions) {
    widest = std::max(widest, std::abs(p.y()));
    if (p.norm() < 1) widest_near_tip = std::max(widest_near_tip, std::abs(p.y()));
  }
  EXPECT_LT(widest_near_tip, 0.15);
  EXPECT_DOUBLE_EQ(widest, 1.2);
}

}  // namespace
}  // namespace spheretree::samples
