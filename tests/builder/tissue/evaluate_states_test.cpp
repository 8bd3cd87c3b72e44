// SPDX-License-Identifier: GPL-3.0-or-later
#include "tissue/evaluate_states.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "geometry/distance_field.h"
#include "support/shape_trees.h"
#include "support/shapes.h"
#include "support/tetrahedra.h"
#include "tissue/anchor_leaves.h"
#include "tissue/bind_surface.h"
#include "tissue/cut_pieces.h"

namespace spheretree::builder {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A cube of 2 mm about the origin, of six tetrahedra, in one leaf: a ball around its corners.
struct SoftCube {
  TriangleMesh mesh = test::quartered(test::boxMesh(-Vector3d::Ones(), Vector3d::Ones()));
  SphereTree tree = test::oneBallTree(std::sqrt(3.0) + 1e-6);
  Tissue tissue;

  SoftCube() {
    Tetrahedra solid = test::boxTetrahedra({2, 2, 2}, {1, 1, 1});
    for (Vector3d& p : solid.nodes) p -= Vector3d::Ones();
    const Vector3d origin(tree.origin_mm.data());
    Progress progress;
    for (const Vector3d& p : solid.nodes) tissue.nodes.push_back({p.x(), p.y(), p.z()});
    tissue.tetrahedra = solid.corners;
    tissue.surface = bindSurface(mesh, solid, origin, progress);
    tissue.leaves = cutPieces(mesh, tree.cover, origin, progress);
    tissue.leaves.anchors = anchorLeaves(mesh, DistanceField(mesh), tissue.surface, solid, tree.cover, origin);
  }
  TissueState mapped(const std::string& kind, const Matrix3d& map, const Vector3d& shift = Vector3d::Zero()) const {
    TissueState state{kind, 0, {}};
    for (const auto& n : tissue.nodes) state.displacements.push_back(map * Vector3d(n.data()) + shift - Vector3d(n.data()));
    return state;
  }
  StatesEvaluation of(const std::vector<TissueState>& states, std::size_t samples = 500, std::uint64_t seed = 1) const {
    Progress progress;
    return evaluateStates(
        mesh, mesh, tree, tissue, states.size(), [&](std::size_t i) { return states[i]; }, samples, seed, progress);
  }
};

// The ball about the centre reaches sqrt(3) - 1 out of each face, wherever the cube is carried and turned to.
TEST(EvaluateStates, ARigidMotionChangesNoFigure) {
  const SoftCube cube;
  const Matrix3d turn = Eigen::AngleAxisd(2, Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  const StatesEvaluation e =
      cube.of({cube.mapped("rest", Matrix3d::Identity()), cube.mapped("moved", turn, {5, 6, 7}), cube.mapped("turned", turn)});
  EXPECT_EQ(e.leaves, 1u);
  EXPECT_EQ(e.samples, 500u);
  EXPECT_NEAR(e.rest_overhang_mm, std::sqrt(3.0) - 1, 1e-5);
  ASSERT_EQ(e.states.size(), 3u);
  for (const StateFigures& s : e.states) {
    ASSERT_TRUE(s.overhang_mm.has_value());
    EXPECT_NEAR(*s.overhang_mm, std::sqrt(3.0) - 1, 1e-5);
    EXPECT_NEAR(s.largest_radius_mm, std::sqrt(3.0), 1e-5);
    EXPECT_NEAR(s.strain.largest_stretch, 1, 1e-9);
    EXPECT_EQ(s.bare_samples, 0u);
    EXPECT_EQ(s.fault, "");
  }
  EXPECT_EQ(e.states[1].kind, "moved");
}

// A leaf keeps its depth of 1 mm below the face that it is attached to. In a cube of 2 s mm its centre is s - 1 mm from
// the middle, and the farthest corners are (s, s, 2 s - 1) away.
TEST(EvaluateStates, FiguresOfALargerCubeAreThoseOfItsGeometry) {
  const SoftCube cube;
  for (const double s : {1.5, 2.0, 4.0}) {
    const StateFigures f = cube.of({cube.mapped("larger", s * Matrix3d::Identity())}).states[0];
    const double radius = std::sqrt(2 * s * s + (2 * s - 1) * (2 * s - 1));
    EXPECT_NEAR(f.largest_radius_mm, radius, 1e-5);
    EXPECT_NEAR(f.overhang_mm.value_or(0), radius - 1, 1e-5);
    EXPECT_NEAR(f.strain.largest_stretch, s, 1e-9);
    EXPECT_NEAR(f.strain.smallest_stretch, s, 1e-9);
    EXPECT_EQ(f.bare_samples, 0u);
  }
}

// A leaf whose centre is half a millimetre above the bottom and whose piece ends at the middle of an edge there, at
// (1, 0, -1): its radius is sqrt(1.25). It holds a disc of 1 mm of the bottom, discs of 0.5 mm of the four sides, and
// nothing of the top.
TEST(EvaluateStates, CountsSamplesThatNoLeafHolds) {
  constexpr std::size_t kSamples = 20'000;
  SoftCube cube;
  std::uint32_t middle = 0;
  while (cube.mesh.positions[middle] != Vector3d(1, 0, -1)) ++middle;
  cube.tissue.leaves.corners = {middle};
  cube.tissue.leaves.begin = {0, 1};
  cube.tissue.leaves.anchors[0].depth = 0.5f;
  const double share = 1 - 2 * std::numbers::pi / 24, deviation = std::sqrt(share * (1 - share) / kSamples);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const StatesEvaluation e = cube.of({cube.mapped("rest", Matrix3d::Identity())}, kSamples, seed);
    EXPECT_NEAR(e.states[0].largest_radius_mm, std::sqrt(1.25), 1e-5);
    EXPECT_NEAR(static_cast<double>(e.states[0].bare_samples) / kSamples, share, 4 * deviation);
  }
}

TEST(EvaluateStates, AnInvertedStateHasNoOverhang) {
  const SoftCube cube;
  const StateFigures f = cube.of({cube.mapped("inverted", Vector3d(1, 1, -1).asDiagonal())}).states[0];
  EXPECT_FALSE(f.overhang_mm.has_value()) << "inside and outside are undefined";
  EXPECT_EQ(f.strain.inverted, 6u);
  EXPECT_EQ(f.bare_samples, 0u) << "the proof does not need upright tetrahedra";
  EXPECT_EQ(f.fault, "");
}

TEST(EvaluateStates, EachStateIsThatOfItsIndexAndACancelledRunEnds) {
  const SoftCube cube;
  std::vector<TissueState> states;
  for (std::size_t i = 0; i < 20; ++i) states.push_back(sampleState(cube.tissue, i, 20, 3));
  const StatesEvaluation all = cube.of(states);
  for (std::size_t i = 0; i < states.size(); ++i) {
    const StateFigures one = cube.of({states[i]}).states[0];
    EXPECT_EQ(all.states[i].kind, states[i].kind);
    EXPECT_EQ(all.states[i].amount, states[i].amount);
    EXPECT_EQ(all.states[i].largest_radius_mm, one.largest_radius_mm);
    EXPECT_EQ(all.states[i].overhang_mm, one.overhang_mm);
  }
  Progress progress;
  progress.cancel();
  EXPECT_THROW(evaluateStates(
                   cube.mesh, cube.mesh, cube.tree, cube.tissue, 1, [&](std::size_t) { return states[0]; }, 10, 1, progress),
               Cancelled);
}

}  // namespace
}  // namespace spheretree::builder
