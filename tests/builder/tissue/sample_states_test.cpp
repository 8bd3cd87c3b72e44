// SPDX-License-Identifier: GPL-3.0-or-later
#include "tissue/sample_states.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <set>

#include "support/tetrahedra.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

Tissue bar() {
  const TetrahedronList solid = test::boxTetrahedra({30, 8, 6}, {6, 3, 2});
  Tissue tissue;
  for (const Vector3d& p : solid.nodes) tissue.nodes.push_back({p.x(), p.y(), p.z()});
  tissue.tetrahedra = solid.corners;
  for (const Vector3d& p : solid.nodes) tissue.surface.push_back({{p.x(), p.y(), p.z()}, 0, {1, 0, 0}});
  return tissue;
}

TEST(SampleState, SameArgumentsSameStateOtherSeedAnother) {
  const Tissue tissue = bar();
  for (std::size_t i = 0; i < 10; ++i) {
    const TissueState a = sampleState(tissue, i, 10, 7), b = sampleState(tissue, i, 10, 7), c = sampleState(tissue, i, 10, 8);
    EXPECT_EQ(a.displacements, b.displacements) << i;
    EXPECT_NE(a.displacements, c.displacements) << i;
  }
}

TEST(SampleState, TheKindsTakeTurnsAndGrowToTheirLargest) {
  const Tissue tissue = bar();
  std::set<std::string> kinds;
  for (std::size_t i = 0; i < 10; ++i) {
    const TissueState early = sampleState(tissue, i % 5, 10, 1), late = sampleState(tissue, 5 + i % 5, 10, 1);
    EXPECT_EQ(early.kind, late.kind);
    EXPECT_NEAR(late.amount, 2 * early.amount, 1e-12);
    kinds.insert(early.kind);
  }
  EXPECT_EQ(kinds, (std::set<std::string>{"squeeze", "poke", "bend", "noise", "inverted"}));
  EXPECT_NEAR(sampleState(tissue, 5, 10, 1).amount, 0.3, 1e-12);
  EXPECT_NEAR(sampleState(tissue, 6, 10, 1).amount, 5, 1e-12);
}

TEST(SampleState, ASqueezeKeepsTheVolumeOfEveryTetrahedron) {
  const Tissue tissue = bar();
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const TissueState state = sampleState(tissue, 5, 10, seed);
    ASSERT_EQ(state.kind, "squeeze");
    const StateStrain strain = strainOf(tissue, state.displacements);
    EXPECT_NEAR(strain.smallest_stretch, 0.7, 1e-9);
    EXPECT_NEAR(strain.largest_stretch, 1 / std::sqrt(0.7), 1e-9);
    EXPECT_EQ(strain.inverted, 0u);
  }
}

TEST(SampleState, NoiseOfAFifthTurnsNothingInsideOutAndThatOfOneAndAHalfMuch) {
  const Tissue tissue = bar();
  EXPECT_GT(strainOf(tissue, sampleState(tissue, 9, 10, 1).displacements).inverted, tissue.tetrahedra.size() / 10);
}

// Neither stretch is 1 when nothing keeps its length.
TEST(StrainOf, FindsTheStretchesOfASolidThatGrowsOrShrinks) {
  const Tissue tissue = bar();
  for (const double factor : {0.5, 2.0}) {
    std::vector<Vector3d> displacements;
    for (const auto& p : tissue.nodes)
      displacements.push_back(Vector3d(factor, 1.1 * factor, 1.2 * factor).cwiseProduct(Vector3d(p.data())) - Vector3d(p.data()));
    const StateStrain strain = strainOf(tissue, displacements);
    EXPECT_NEAR(strain.largest_stretch, 1.2 * factor, 1e-9);
    EXPECT_NEAR(strain.smallest_stretch, factor, 1e-9);
  }
}

TEST(StrainOf, FindsTheStretchesOfAMap) {
  const Tissue tissue = bar();
  Eigen::Matrix3d map;
  map << 1.5, 0, 0, 0, 0.8, 0, 0, 0, 1;
  std::vector<Vector3d> displacements;
  for (const auto& p : tissue.nodes) {
    const Vector3d at(p[0], p[1], p[2]);
    displacements.push_back(map * at - at);
  }
  const StateStrain strain = strainOf(tissue, displacements);
  EXPECT_NEAR(strain.largest_stretch, 1.5, 1e-9);
  EXPECT_NEAR(strain.smallest_stretch, 0.8, 1e-9);
  for (Vector3d& d : displacements) d.z() = 0;
  for (std::size_t i = 0; i < tissue.nodes.size(); ++i) displacements[i].z() = -2 * tissue.nodes[i][2];  // mirrored
  EXPECT_EQ(strainOf(tissue, displacements).inverted, tissue.tetrahedra.size());
}

}  // namespace
}  // namespace spheretree::builder
