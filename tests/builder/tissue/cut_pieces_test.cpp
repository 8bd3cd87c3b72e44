// SPDX-License-Identifier: GPL-3.0-or-later
#include "tissue/cut_pieces.h"

#include <gtest/gtest.h>

#include <set>

#include "spheretree/builder/build_sphere_tree.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

Sphere ball(double x, double y, double z, double r) {
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), static_cast<float>(r)};
}

Vector3d placeOf(const TriangleMesh& mesh, const TissueLeaves& leaves, std::uint32_t corner) {
  if (corner < mesh.positions.size()) return mesh.positions[corner];
  const TissueCut& cut = leaves.cuts[corner - mesh.positions.size()];
  return (1 - cut.weight[0] - cut.weight[1]) * mesh.positions[cut.vertex[0]] + cut.weight[0] * mesh.positions[cut.vertex[1]] +
         cut.weight[1] * mesh.positions[cut.vertex[2]];
}

TEST(CutPieces, OneLeafAroundAllHasEveryVertexAndNoCut) {
  const TriangleMesh mesh = test::boxMesh({0, 0, 0}, {3, 2, 1});
  Progress progress;
  const TissueLeaves leaves = cutPieces(mesh, std::vector{ball(1.5, 1, 0.5, 5)}, Vector3d::Zero(), progress);
  EXPECT_TRUE(leaves.cuts.empty());
  EXPECT_EQ(leaves.corners.size(), 8u);
  EXPECT_EQ(leaves.begin, (std::vector<std::uint32_t>{0, 8}));
}

TEST(CutPieces, TwoLeavesShareTheSurfaceAtThePlaneOfEqualPower) {
  const TriangleMesh mesh = test::boxMesh({-2, -1, -1}, {2, 1, 1});
  Progress progress;
  const std::vector balls{ball(-1, 0, 0, 2), ball(1, 0, 0, 2)};
  const TissueLeaves leaves = cutPieces(mesh, balls, Vector3d::Zero(), progress);
  ASSERT_EQ(leaves.begin.size(), 3u);
  EXPECT_FALSE(leaves.cuts.empty());
  for (std::size_t cut = 0; cut < leaves.cuts.size(); ++cut)
    EXPECT_NEAR(placeOf(mesh, leaves, static_cast<std::uint32_t>(mesh.positions.size() + cut)).x(), 0, 1e-9);
  for (std::size_t leaf = 0; leaf < 2; ++leaf)
    for (std::uint32_t i = leaves.begin[leaf]; i < leaves.begin[leaf + 1]; ++i) {
      const double x = placeOf(mesh, leaves, leaves.corners[i]).x();
      EXPECT_LE(leaf == 0 ? x : -x, 1e-9) << "each corner is on the side of its leaf";
    }
}

TEST(CutPieces, EveryCornerLiesInItsLeafAndEveryVertexInSomeLeaf) {
  const TriangleMesh mesh = test::sphereMesh(5, 3);
  Progress progress;
  BuildSettings settings;
  settings.levels = 3;
  settings.quality = Quality::Quick;
  const SphereTree tree = buildSphereTree(mesh, settings, progress).tree;
  std::vector<Sphere> balls;
  for (const std::uint32_t leaf : levelSet(tree, tree.levelCount() - 1)) balls.push_back(tree.cover[leaf]);
  const Vector3d origin(tree.origin_mm[0], tree.origin_mm[1], tree.origin_mm[2]);
  const TissueLeaves leaves = cutPieces(mesh, balls, origin, progress);
  std::set<std::uint32_t> vertices;
  for (std::size_t leaf = 0; leaf < balls.size(); ++leaf)
    for (std::uint32_t i = leaves.begin[leaf]; i < leaves.begin[leaf + 1]; ++i) {
      const Vector3d centre = Vector3d(balls[leaf].x, balls[leaf].y, balls[leaf].z) + origin;
      EXPECT_LE((placeOf(mesh, leaves, leaves.corners[i]) - centre).norm(), static_cast<double>(balls[leaf].radius) + 1e-6);
      EXPECT_TRUE(i == leaves.begin[leaf] || leaves.corners[i - 1] < leaves.corners[i]) << "ascending, each once";
      if (leaves.corners[i] < mesh.positions.size()) vertices.insert(leaves.corners[i]);
    }
  EXPECT_EQ(vertices.size(), mesh.positions.size());
}

TEST(CutPieces, RefusesLeavesThatLeaveSurfaceBare) {
  const TriangleMesh mesh = test::boxMesh({-2, -1, -1}, {2, 1, 1});
  Progress progress;
  EXPECT_THROW(cutPieces(mesh, std::vector{ball(-1, 0, 0, 2)}, Vector3d::Zero(), progress), BuildError);
}

}  // namespace
}  // namespace spheretree::builder
