// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/tissue.h"

#include <gtest/gtest.h>

#include <limits>

#include "support/random.h"
#include "support/sample_skins.h"
#include "support/sample_tissue.h"
#include "support/sample_trees.h"

namespace spheretree {
namespace {

TEST(TissueMaterial, IsRefusedOutOfTheRangeOfTissue) {
  EXPECT_EQ(findFault(TissueMaterial{15, 0.45, 1040}), "");
  EXPECT_NE(findFault(TissueMaterial{0.015, 0.45, 1040}).find("MPa"), std::string::npos);
  EXPECT_NE(findFault(TissueMaterial{15e6, 0.45, 1040}).find("Pa"), std::string::npos);
  EXPECT_NE(findFault(TissueMaterial{15, 0.5, 1040}).find("Poisson"), std::string::npos);
  EXPECT_NE(findFault(TissueMaterial{15, -0.1, 1040}).find("Poisson"), std::string::npos);
  EXPECT_NE(findFault(TissueMaterial{15, 0.45, 1.04}).find("g/cm^3"), std::string::npos);
  EXPECT_NE(findFault(TissueMaterial{std::numeric_limits<double>::quiet_NaN(), 0.45, 1040}), "");
}

TEST(Tissue, FindsEveryBrokenRule) {
  const Tissue sound = test::twoTetrahedra(test::softTree());
  EXPECT_EQ(findFault(sound), "");
  const auto broken = [&](auto change) {
    Tissue tissue = sound;
    change(tissue);
    return findFault(tissue);
  };
  EXPECT_NE(broken([](Tissue& t) { t.material.young_kpa = 0; }), "");
  EXPECT_NE(broken([](Tissue& t) { t.nodes.resize(3); }), "");
  EXPECT_NE(broken([](Tissue& t) { t.nodes[1][2] = std::numeric_limits<double>::infinity(); }), "");
  EXPECT_NE(broken([](Tissue& t) { t.fixed = {2, 0}; }), "");
  EXPECT_NE(broken([](Tissue& t) { t.fixed = {5}; }), "");
  EXPECT_NE(broken([](Tissue& t) { t.tetrahedra.clear(); }), "");
  EXPECT_NE(broken([](Tissue& t) { t.tetrahedra[1][3] = 5; }), "");
  EXPECT_NE(broken([](Tissue& t) { std::swap(t.tetrahedra[0][0], t.tetrahedra[0][1]); }), "");
  EXPECT_NE(broken([](Tissue& t) { t.surface.clear(); }), "");
  EXPECT_NE(broken([](Tissue& t) { t.surface[1].tetrahedron = 2; }), "");
  EXPECT_NE(broken([](Tissue& t) { t.surface[1].weight[1] = std::numeric_limits<float>::quiet_NaN(); }), "");
  EXPECT_NE(broken([](Tissue& t) { t.leaves.cuts[1].vertex[2] = 3; }), "");
  EXPECT_NE(broken([](Tissue& t) { t.leaves.anchors[0].tetrahedron = 2; }), "");
  EXPECT_NE(broken([](Tissue& t) { t.leaves.anchors[0].depth = -1; }), "");
  EXPECT_NE(broken([](Tissue& t) { t.leaves.begin[1] = 99; }), "");
  EXPECT_NE(broken([](Tissue& t) { t.leaves.begin.pop_back(); }), "");
  EXPECT_NE(broken([](Tissue& t) { t.leaves.corners[0] = 5; }), "");
  EXPECT_NE(broken([](Tissue& t) { t.response.pressed = {3, 1}; }), "");
  EXPECT_NE(broken([](Tissue& t) { t.response.pressed[1] = 5; }), "");
  EXPECT_NE(broken([](Tissue& t) { t.response.points[0].node[1] = 2; }), "");
  EXPECT_NE(broken([](Tissue& t) { t.response.points[0].weight[1] = -1; }), "");
  EXPECT_NE(broken([](Tissue& t) { t.response.matrix.pop_back(); }), "");
  EXPECT_NE(broken([](Tissue& t) { t.response.matrix[4] = std::numeric_limits<float>::quiet_NaN(); }), "");
  EXPECT_EQ(broken([](Tissue& t) { t.response = {}; }), "");
}

TEST(Tissue, HasTheLeavesOfItsTree) {
  const Tissue tissue = test::twoTetrahedra(test::softTree());
  EXPECT_EQ(findFault(tissue, test::softTree()), "");
  Tissue short_of_points = tissue;
  short_of_points.response.points.pop_back();
  EXPECT_NE(findFault(short_of_points, test::softTree()), "");
  EXPECT_NE(findFault(tissue, test::randomTree(1, 4, 5)), "");
}

TEST(Tissue, AMovedTreeIsSoundWhateverItsLeaves) {
  test::Random random(1);
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const SphereTree tree =
        test::withSearch(test::randomTree(seed, 2 + static_cast<int>(seed % 5), 2 + static_cast<int>(seed % 7)), 2 + seed % 7);
    std::vector<Sphere> leaves;
    for (std::size_t i = 0; i < levelSet(tree, tree.levelCount() - 1).size(); ++i) {
      const Eigen::Vector3f c = random.inCube(100).cast<float>();
      leaves.push_back({c.x(), c.y(), c.z(), static_cast<float>(random.between(1e-6, 5))});
    }
    const SphereTree moved = movedTree(tree, leaves);
    EXPECT_EQ(findFault(moved), "") << seed;
    EXPECT_EQ(moved.child_count, tree.child_count);
  }
}

TEST(Tissue, SurfaceMovesByTheWeightsOfItsTetrahedron) {
  const Tissue tissue = test::twoTetrahedra(test::softTree());
  std::vector<Eigen::Vector3d> displacements(5, Eigen::Vector3d::Zero()), positions(3);
  displacements[0] = {1, 2, 3};
  displacements[4] = {0, 0, 4};
  moveSurface(tissue, displacements, positions);
  EXPECT_EQ(positions[0], Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(positions[1], Eigen::Vector3d(0.5, 0.5, 1.5));
  EXPECT_EQ(positions[2], Eigen::Vector3d(1, 1, 5));
}

}  // namespace
}  // namespace spheretree
