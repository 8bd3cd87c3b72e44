// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/canonical_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "spheretree/builder/build_sphere_tree.h"
#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

template <class T>
void shuffle(std::vector<T>& list, test::Random& random) {
  for (std::size_t i = list.size(); i > 1; --i) std::swap(list[i - 1], list[random.below(i)]);
}

TriangleMesh inOtherOrder(const TriangleMesh& mesh, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<std::uint32_t> place(mesh.positions.size());
  std::iota(place.begin(), place.end(), 0u);
  shuffle(place, random);
  TriangleMesh out = mesh;
  for (std::size_t v = 0; v < place.size(); ++v) out.positions[place[v]] = mesh.positions[v];
  for (Triangle& t : out.triangles) {
    for (std::uint32_t& v : t) v = place[v];
    std::rotate(t.begin(), t.begin() + static_cast<std::ptrdiff_t>(random.below(3)), t.end());
  }
  shuffle(out.triangles, random);
  return out;
}

TEST(CanonicalOrder, IsTheSameForEveryOrder) {
  const TriangleMesh mesh = test::torusMesh(4, 1.3, 12, 9);
  const OrderedMesh ordered = inCanonicalOrder(mesh);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const OrderedMesh other = inCanonicalOrder(inOtherOrder(mesh, seed));
    EXPECT_EQ(other.mesh.positions, ordered.mesh.positions);
    EXPECT_EQ(other.mesh.triangles, ordered.mesh.triangles);
  }
}

TEST(CanonicalOrder, KeepsTriangleAndSide) {
  const TriangleMesh mesh = inOtherOrder(test::torusMesh(4, 1, 10, 7), 9);
  const OrderedMesh ordered = inCanonicalOrder(mesh);
  ASSERT_EQ(ordered.triangle.size(), mesh.triangles.size());
  std::vector<char> seen(mesh.triangles.size(), 0);
  for (std::size_t t = 0; t < ordered.triangle.size(); ++t) {
    const std::uint32_t from = ordered.triangle[t];
    seen.at(from) = 1;
    bool same = false;  // up to the rotation of its corners
    for (int start = 0; start < 3; ++start) {
      bool all = true;
      for (int k = 0; k < 3; ++k) all = all && ordered.mesh.corner(t, k) == mesh.corner(from, (start + k) % 3);
      same = same || all;
    }
    EXPECT_TRUE(same) << t;
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(seen.size())) << "each once";
}

TEST(CanonicalOrder, ScalingByPowersOfTwoChangesNothing) {
  const TriangleMesh mesh = test::torusMesh(4, 1.3, 12, 9);
  TriangleMesh scaled = mesh;
  for (Eigen::Vector3d& p : scaled.positions) p *= 0x1p-9;
  EXPECT_EQ(inCanonicalOrder(scaled).triangle, inCanonicalOrder(mesh).triangle);
}

TEST(CanonicalOrder, TreesDoNotDependOnTheOrder) {
  const TriangleMesh mesh = test::boxMesh({0, 0, 0}, {3, 2, 1}), other = inOtherOrder(mesh, 4);
  ASSERT_NE(other.triangles, mesh.triangles);
  Progress progress;
  for (const BuilderKind kind : {BuilderKind::Cover, BuilderKind::Merge, BuilderKind::Grid, BuilderKind::Octree}) {
    BuildSettings settings;
    settings.builder = kind;
    settings.quality = Quality::Quick;
    settings.levels = 3;
    const SphereTree a = buildSphereTree(mesh, settings, progress).tree, b = buildSphereTree(other, settings, progress).tree;
    EXPECT_EQ(a.cover, b.cover) << name(kind);
    EXPECT_EQ(a.bound, b.bound) << name(kind);
    EXPECT_NE(a.provenance.mesh_hash, b.provenance.mesh_hash) << "the hash is that of the mesh as it was given";
  }
}

// The tolerance of a triangle moves with the triangle.
TEST(CanonicalOrder, GradedTolerancesFollowTheirTriangles) {
  const TriangleMesh mesh = test::boxMesh({0, 0, 0}, {3, 2, 1}), other = inOtherOrder(mesh, 6);
  const auto graded = [](const TriangleMesh& m) {
    BuildSettings settings;
    settings.quality = Quality::Quick;
    settings.tolerance_mm = 0.15;
    for (std::size_t t = 0; t < m.triangles.size(); ++t) {
      const bool fine = m.corner(t, 0).x() + m.corner(t, 1).x() + m.corner(t, 2).x() > 8.9;  // the face x = 3
      settings.tolerance_of_triangle_mm.push_back(fine ? 0.15 : 0.6);
    }
    return settings;
  };
  Progress progress;
  EXPECT_EQ(buildSphereTree(mesh, graded(mesh), progress).tree.cover, buildSphereTree(other, graded(other), progress).tree.cover);
  BuildSettings wrong = graded(mesh);
  wrong.tolerance_of_triangle_mm.pop_back();
  EXPECT_THROW(buildSphereTree(mesh, wrong, progress), std::invalid_argument);
}

}  // namespace
}  // namespace spheretree::builder
