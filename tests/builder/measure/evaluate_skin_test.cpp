// SPDX-License-Identifier: GPL-3.0-or-later
#include "measure/evaluate_skin.h"

#include <gtest/gtest.h>

#include "support/sample_skins.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

TEST(SkinFigures, CountABox) {
  const Skin skin = test::boxSkin({1, 2, 0.5});
  const SkinEvaluation figures = skinFigures(skin);
  EXPECT_EQ(figures.triangles, 12u);
  EXPECT_EQ(figures.flat_triangles, 12u);
  EXPECT_EQ(figures.triangles, skin.triangles.size());
  EXPECT_GE(figures.sharp_edges, 12u) << "a sharp edge counts for each of its triangles";
  EXPECT_NEAR(figures.edge_angle_max, 0, 1e-6) << "the edges that are not sharp are diagonals of its faces";
}

TEST(SkinFigures, FacetsOfASphereBendByWhatTheirSizeSays) {
  // An edge of length a between flat triangles of a sphere of radius R bends by about a / (sqrt(3) R): halving the
  // edges halves the angle.
  const SkinEvaluation coarse = skinFigures(test::roundSkin(3)), fine = skinFigures(test::roundSkin(4));
  EXPECT_EQ(fine.triangles, 4 * coarse.triangles);
  EXPECT_NEAR(coarse.edge_angle_median / fine.edge_angle_median, 2, 0.1);
  EXPECT_LE(fine.edge_angle_median, fine.edge_angle_p99);
  EXPECT_LE(fine.edge_angle_p99, fine.edge_angle_max);
  EXPECT_EQ(fine.sharp_edges, 0u);
}

TEST(SkinFigures, FlatTrianglesAreMovedByTheOrigin) {
  const Skin skin = test::roundSkin(2);
  const TriangleMesh here = flatTriangles(skin, Vector3d::Zero()), there = flatTriangles(skin, {100, -20, 3});
  ASSERT_EQ(here.triangles, there.triangles);
  ASSERT_EQ(here.triangles.size(), skin.triangles.size());
  for (std::size_t i = 0; i < here.positions.size(); ++i)
    EXPECT_LT((there.positions[i] - here.positions[i] - Vector3d(100, -20, 3)).norm(), 1e-9);
}

TEST(EvaluateSkin, FindsAKnownOffset) {
  // The skin of a sphere against its own mesh, and against that mesh moved by 0.25 mm: no point can be off by more than
  // a rigid shift, and the pole in its direction is off by exactly that.
  const double radius = 5, shift = 0.25;
  const Skin skin = test::roundSkin(4, radius);
  const TriangleMesh own = flatTriangles(skin, Vector3d::Zero()), moved = flatTriangles(skin, {0, 0, shift});
  Progress progress;
  const SkinEvaluation same = evaluateSkin(skin, Vector3d::Zero(), own, DistanceField(own), progress);
  ASSERT_TRUE(same.from_mesh && same.of_mesh);
  EXPECT_LT(*same.from_mesh, 1e-5);
  EXPECT_LT(*same.of_mesh, 1e-5);
  const SkinEvaluation off = evaluateSkin(skin, Vector3d::Zero(), moved, DistanceField(moved), progress);
  for (const double distance : {*off.from_mesh, *off.of_mesh}) {
    EXPECT_GE(distance, 0.98 * shift);
    EXPECT_LE(distance, 1.05 * shift + 0.25 * off.mesh_distance);
  }
}

TEST(EvaluateSkin, StopsWhenAsked) {
  const Skin skin = test::roundSkin(4);
  const TriangleMesh mesh = flatTriangles(skin, {0.5, 0, 0});
  Progress progress;
  progress.cancel();
  EXPECT_THROW(evaluateSkin(skin, Vector3d::Zero(), mesh, DistanceField(mesh), progress), Cancelled);
}

}  // namespace
}  // namespace spheretree::builder
