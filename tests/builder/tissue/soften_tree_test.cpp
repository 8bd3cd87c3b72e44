// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/soften_tree.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "spheretree/builder/build_sphere_tree.h"
#include "support/random.h"
#include "support/sample_trees.h"
#include "support/shapes.h"
#include "support/tetrahedra.h"
#include "tissue/evaluate_states.h"
#include "tissue/sample_states.h"
#include "tissue/tetrahedra.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

constexpr TissueMaterial kSoftTissue{15, 0.45, 1040};

/// A box of tetrahedra whose surface a mesh follows only roughly, as after simplification of a scan; far from the
/// origin.
struct SoftBox {
  TriangleMesh mesh, boundary;
  TetrahedronList tetrahedra;
  SphereTree tree;
  Tissue tissue;
};

SoftBox softBox(double roughness, int levels, std::uint64_t seed, double share = 0) {
  const Vector3d size(30, 20, 12), at(300, -200, 50);
  SoftBox box;
  box.boundary = test::boxMesh(at, at + size);
  box.tetrahedra = test::boxTetrahedra(size, {6, 4, 3});
  for (Vector3d& p : box.tetrahedra.nodes) p += at;
  box.mesh = test::quartered(test::quartered(test::quartered(box.boundary)));
  test::Random random(seed);
  for (Vector3d& p : box.mesh.positions) p += random.inCube(roughness);
  Progress progress;
  BuildSettings settings;
  settings.levels = levels;
  settings.quality = Quality::Quick;
  settings.seed = seed;
  settings.soft_share = share;
  box.tree = buildSphereTree(box.mesh, settings, progress).tree;
  box.tissue = softenTree(
      box.mesh, box.tree, box.boundary, box.tetrahedra, kSoftTissue, [&](const Vector3d& p) { return p.z() < at.z() + 1; }, progress);
  return box;
}

struct Moved {
  std::vector<Vector3d> surface;
  std::vector<Sphere> leaves;
};

Moved movedBy(const Tissue& tissue, const std::vector<Vector3d>& displacements) {
  Moved moved{std::vector<Vector3d>(tissue.surface.size()), std::vector<Sphere>(tissue.leaves.anchors.size())};
  moveSurface(tissue, displacements, moved.surface);
  moveLeaves(tissue, displacements, moved.surface, moved.leaves);
  return moved;
}

bool isHeld(const std::vector<Sphere>& leaves, const Vector3d& p) {
  return std::any_of(leaves.begin(), leaves.end(), [&](const Sphere& s) {
    return (p - Vector3d(s.x, s.y, s.z)).squaredNorm() <= static_cast<double>(s.radius) * static_cast<double>(s.radius);
  });
}

TEST(SoftenTree, AtRestTheLeavesAreThoseOfTheTreeOrSmaller) {
  const SoftBox box = softBox(0.3, 3, 1);
  const Moved rest = movedBy(box.tissue, std::vector<Vector3d>(box.tissue.nodes.size(), Vector3d::Zero()));
  const std::vector<Sphere> leaves = test::leavesOf(box.tree);
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    EXPECT_LT((Vector3d(rest.leaves[i].x, rest.leaves[i].y, rest.leaves[i].z) - Vector3d(leaves[i].x, leaves[i].y, leaves[i].z)).norm(),
              2e-4);
    EXPECT_LT(rest.leaves[i].radius, leaves[i].radius + 2e-4f);
  }
}

// The certificate: 10^4 states, from small deformations to states in which most tetrahedra are inverted.
TEST(SoftenTree, TheLeavesHoldTheMovedSurfaceInEveryState) {
  constexpr std::size_t kStates = 10'000, kSamples = 100;
  const SoftBox box = softBox(0.3, 3, 2);
  test::Random random(7);
  std::size_t inverted = 0;
  for (std::size_t i = 0; i < kStates; ++i) {
    const TissueState state = sampleState(box.tissue, i, kStates, 5);
    const Moved moved = movedBy(box.tissue, state.displacements);
    inverted += i % 100 == 4 && strainOf(box.tissue, state.displacements).inverted > box.tissue.tetrahedra.size() / 5;
    for (std::size_t k = 0; k < kSamples; ++k) {
      const Triangle& t = box.mesh.triangles[random.below(box.mesh.triangles.size())];
      double u = random.unit(), v = random.unit();
      if (u + v > 1) u = 1 - u, v = 1 - v;
      if (k % 4 == 0) v = 0;  // points of edges, which belong to two triangles
      const Vector3d p = (1 - u - v) * moved.surface[t[0]] + u * moved.surface[t[1]] + v * moved.surface[t[2]];
      ASSERT_TRUE(isHeld(moved.leaves, p)) << state.kind << " " << state.amount << ", state " << i;
    }
  }
  EXPECT_GT(inverted, 10u);
}

TEST(SoftenTree, AShrunkenLeafLeavesTheSurfaceBare) {  // proves that the test above can fail
  const SoftBox box = softBox(0.3, 3, 2);
  std::size_t bare = 0;
  for (std::size_t i = 0; i < 50; ++i) {
    Moved moved = movedBy(box.tissue, sampleState(box.tissue, i, 50, 5).displacements);
    for (Sphere& s : moved.leaves) s.radius *= 0.98f;
    for (const std::uint32_t corner : box.tissue.leaves.corners)
      if (corner < moved.surface.size()) bare += !isHeld(moved.leaves, moved.surface[corner]);
  }
  EXPECT_GT(bare, 50u);
}

TEST(SoftenTree, RigidMotionTurnsTheLeavesAndKeepsTheirRadii) {
  const SoftBox box = softBox(0.2, 3, 3);
  const Eigen::AngleAxisd turn(0.8, Vector3d(1, 2, -1).normalized());
  std::vector<Vector3d> displacements;
  for (const auto& n : box.tissue.nodes) {
    const Vector3d p(n[0], n[1], n[2]);
    displacements.push_back(turn * p + Vector3d(5, 6, 7) - p);
  }
  const Moved rest = movedBy(box.tissue, std::vector<Vector3d>(box.tissue.nodes.size(), Vector3d::Zero())),
              moved = movedBy(box.tissue, displacements);
  for (std::size_t i = 0; i < rest.leaves.size(); ++i) {
    const Vector3d wanted = turn * Vector3d(rest.leaves[i].x, rest.leaves[i].y, rest.leaves[i].z) + Vector3d(5, 6, 7);
    EXPECT_LT((Vector3d(moved.leaves[i].x, moved.leaves[i].y, moved.leaves[i].z) - wanted).norm(), 1e-3);
    EXPECT_NEAR(moved.leaves[i].radius, rest.leaves[i].radius, 1e-3);
  }
}

TEST(SoftenTree, EvaluationFindsNothingBareAndTreesSound) {
  const SoftBox box = softBox(0.1, 3, 4);
  Progress progress;
  const auto state = [&](std::size_t i) { return sampleState(box.tissue, i, 50, 9); };
  const StatesEvaluation e = evaluateStates(box.mesh, box.mesh, box.tree, box.tissue, 50, state, 2000, 1, progress);
  EXPECT_GT(e.rest_overhang_mm, 0);
  for (const StateFigures& s : e.states) {
    EXPECT_EQ(s.bare_samples, 0u) << s.kind;
    EXPECT_EQ(s.fault, "") << s.kind;
    EXPECT_EQ(s.overhang_mm.has_value(), s.strain.inverted == 0);
    if (s.kind == "squeeze") {
      EXPECT_NEAR(s.strain.smallest_stretch, 1 - s.amount, 1e-6);
    }
  }
}

float largestRadius(const SphereTree& tree) {
  float largest = 0;
  for (const Sphere& s : test::leavesOf(tree)) largest = std::max(largest, s.radius);
  return largest;
}

double worstOverhang(const SoftBox& box, const std::string& kind) {
  Progress progress;
  const auto state = [&](std::size_t i) { return sampleState(box.tissue, i, 25, 9); };
  double worst = 0;
  for (const StateFigures& s : evaluateStates(box.mesh, box.mesh, box.tree, box.tissue, 25, state, 500, 1, progress).states)
    if (s.kind == kind && s.overhang_mm) worst = std::max(worst, *s.overhang_mm);
  return worst;
}

// The box is 12 mm thick: the largest ball in it has a radius of 6 mm.
TEST(SoftenTree, LeavesForTissueStayNearTheSurfaceAndFollowItBetter) {
  const SoftBox rigid = softBox(0.05, 4, 6), soft = softBox(0.05, 4, 6, 0.5), softer = softBox(0.05, 4, 6, 0.25);
  EXPECT_GT(largestRadius(rigid.tree), 5.5f);
  const auto bound = [](const SoftBox& box) { return box.tree.statistics.back().overhang_bound; };
  EXPECT_LT(largestRadius(soft.tree), 3 + 1.2f * bound(soft));
  EXPECT_LT(largestRadius(softer.tree), 1.5f + 1.2f * bound(softer));
  EXPECT_LT(worstOverhang(soft, "squeeze"), 0.7 * worstOverhang(rigid, "squeeze"));
}

TEST(SoftenTree, AnotherMeshIsRefused) {
  const SoftBox box = softBox(0.1, 2, 5);
  TriangleMesh other = box.mesh;
  for (Vector3d& p : other.positions) p += Vector3d(9, 0, 0);
  Progress progress;
  EXPECT_THROW(softenTree(
                   other, box.tree, box.boundary, box.tetrahedra, kSoftTissue, [](const Vector3d& p) { return p.z() < 51; }, progress),
               BuildError);
}

}  // namespace
}  // namespace spheretree::builder
