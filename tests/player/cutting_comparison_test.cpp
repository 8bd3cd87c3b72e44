// SPDX-License-Identifier: GPL-3.0-or-later
// Drilling in voxels, and its comparison with our cutting. Subject: published/voxel_renderer.h, comparison/cutting.h
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "comparison/cutting.h"
#include "published/voxel_renderer.h"
#include "support/random.h"
#include "support/sample_skins.h"
#include "support/shape_trees.h"

namespace spheretree::player {
namespace {

using Eigen::Vector3d;
using test::Random;

constexpr double kEdge = 0.1;

/// A burr that is all of the tool, with its block of the given half edges about the origin.
struct Drill {
  runtime::SceneDescription description;
  runtime::Scene scene;
  builder::DistanceField field;
  std::unique_ptr<VoxelRenderer> renderer;

  Drill(double radius, const Vector3d& half, const Configuration& place = {}) : field(box(-half, half)) {
    description.tool = test::treeOfBalls({test::ball(0, 0, 0, static_cast<float>(radius))});
    description.burr = {{{0, 0, 0}, radius}};
    description.objects.push_back({test::withSkin(test::boxTree(half, {4, 4, 4}, 1), test::boxSkin(half)), place});
    std::string fault;
    description.objects[0].cut = runtime::cutModel(description.objects[0].tree, {1, {}, 0}, fault);
    EXPECT_TRUE(runtime::compileScene(description, scene, fault)) << fault;
    const CutSolid solid{0, &field};
    renderer = std::make_unique<VoxelRenderer>(description, scene, std::span(&solid, 1), kEdge);
  }
  runtime::StepResult to(const Vector3d& position) { return renderer->step({position, {1, 0, 0, 0}}); }
};

TEST(VoxelRenderer, RestsOnTheBallsThatStandForVoxels) {
  for (const double radius : {0.3, 0.5, 1.0}) {
    const Configuration place{{2, -1, 3}, Quaternion(0.6, 0.8, 0, 0)};
    Drill drill(radius, {2, 2, 1}, place);
    const auto at = [&](double height) -> Vector3d { return place.position + place.orientation * Vector3d(0, 0, 1 + height); };
    runtime::StepResult r;
    for (double height = radius + 0.5; height > radius - 0.4; height -= 0.01) r = drill.to(at(height));
    for (int n = 0; n < 100; ++n) r = drill.to(at(radius - 0.4));
    // Above a corner of four voxels: their centres are half an edge below the face and an edge / sqrt 2 aside.
    const double rest = std::sqrt(std::pow(radius + 0.7 * kEdge, 2) - kEdge * kEdge / 2) - kEdge / 2;
    EXPECT_NEAR((place.orientation.conjugate() * (r.graphic.position - place.position)).z(), 1 + rest, 1e-3) << radius;
    EXPECT_NEAR(r.wrench.force.norm(), rest - radius + 0.4, 1e-3);
    EXPECT_LT(r.wrench.torque.norm(), 1e-9);
    EXPECT_EQ(drill.renderer->removed(), 0u) << "the spindle rests";
    drill.renderer->restart();
    EXPECT_EQ(drill.to(at(5)).wrench.force.norm(), 0);
  }
}

TEST(VoxelRenderer, RemovesAtMostItsNumberAndPullsNoMoreThanTheHand) {
  EXPECT_EQ(VoxelRenderer::mostRemoved(0.5), 1u);
  EXPECT_EQ(VoxelRenderer::mostRemoved(1), 1u);
  EXPECT_EQ(VoxelRenderer::mostRemoved(3), 3u);
  EXPECT_EQ(VoxelRenderer::mostRemoved(4), 6u);
  EXPECT_EQ(VoxelRenderer::mostRemoved(20), 10u);
  for (const double radius : {0.5, 1.0, 2.0, 3.0}) {
    Drill drill(radius, {3, 3, 1});
    drill.renderer->setSpindle(true);
    Random random(5);
    Vector3d hand(0, 0, 1.2 + radius), goal = hand;
    double force = drill.to(hand).wrench.force.norm();
    std::size_t removed = 0, largest = 0;
    for (int n = 0; n < 3000; ++n) {
      if (n % 200 == 0) goal = {random.between(-2, 2), random.between(-2, 2), 1 + radius + random.between(-1.2, 0.2)};
      const Vector3d last = hand;
      hand += 0.01 * (goal - hand);
      const runtime::StepResult r = drill.to(hand);
      // The spring is stretched by what the hand moves at most; whatever is removed relieves it.
      ASSERT_LE(r.wrench.force.norm(), force + drill.description.coupling.translation * (hand - last).norm() + 1e-9);
      force = r.wrench.force.norm();
      largest = std::max(largest, drill.renderer->removed() - removed);
      removed = drill.renderer->removed();
    }
    EXPECT_EQ(largest, VoxelRenderer::mostRemoved(2 * radius));
    EXPECT_GT(removed, 100u);
  }
}

TEST(VoxelRenderer, RemovesTheVolumeOfItsVoxels) {
  const Vector3d half(0.5, 0.3, 0.2);
  Drill drill(1, half);
  drill.renderer->setSpindle(true);
  for (double z = 1.5; z > -2; z -= 0.005) drill.to({0, 0, z});
  EXPECT_NEAR(static_cast<double>(drill.renderer->removed()) * std::pow(kEdge, 3), 8 * half.prod(), 1e-9) << "all of the block";
  EXPECT_LT(drill.to({0, 0, -2}).wrench.force.norm(), 1e-9);
}

/// Archimedes' cap, and a cylinder above it.
double drilled(double depth, double r) {
  const double cap = std::clamp(depth, 0.0, r);
  return std::numbers::pi * cap * cap * (r - cap / 3) + std::numbers::pi * r * r * std::max(0.0, depth - r);
}

TEST(CuttingComparison, OursHasTheSmallerStepsOnTurnedAndScaledBlocks) {
  builder::Progress progress;
  BodyLibrary bodies(builder::Quality::Quick, runtime::ContactSurface::Skin, progress);
  struct Case {
    double scale;
    Quaternion turn;
  };
  for (const Case& c : std::array<Case, 3>{
           {{1, {1, 0, 0, 0}}, {0.7, Quaternion(0.9, 0.2, -0.3, 0.1).normalized()}, {1.3, Quaternion(0.3, -0.5, 0.1, 0.8).normalized()}}})
    for (const CuttingCourse& course : cuttingBench(bodies, c.scale * Vector3d(3, 3, 2), c.turn)) {
      if (course.hand.poses.size() > 1000) continue;  // the fast ones are as many and short
      SCOPED_TRACE(course.name + ", " + std::to_string(c.scale));
      const std::vector<CuttingRow> rows = compareCutting(course, kEdge, progress);
      ASSERT_EQ(rows.size(), 2u);
      const CuttingRow &ours = rows[0], &voxels = rows[1];
      EXPECT_EQ(voxels.renderer, "voxels");
      EXPECT_EQ(ours.force.size(), course.hand.poses.size());
      EXPECT_LT(ours.beyond, 0.02) << "the requirement";
      EXPECT_LT(ours.beyond, voxels.beyond);
      EXPECT_LT(ours.change_largest, voxels.change_largest);
      EXPECT_GT(ours.removed, ours.swept.low * 0.97);
      EXPECT_LT(ours.removed, ours.swept.high * 1.03);
      EXPECT_GT(voxels.removed, voxels.swept.low) << "a ball of 0.7 edges stands for a voxel, so that more is removed";
      EXPECT_LT(voxels.largest_torque, 1e-6);
      EXPECT_GT(ours.largest_torque, 0.01);
    }
}

TEST(CuttingComparison, SweptIsTheClosedFormOfAPlunge) {
  builder::Progress progress;
  BodyLibrary bodies(builder::Quality::Quick, runtime::ContactSurface::Skin, progress);
  CuttingCourse course = cuttingBench(bodies, {3, 3, 2})[0];
  std::string fault;
  course.scene.objects[0].cut = runtime::cutModel(course.scene.objects[0].tree, {20, {}, 0}, fault);
  const std::vector<CuttingRow> rows = compareCutting(course, kEdge, progress);
  for (const CuttingRow& row : rows) {  // the lag behind the hand is the force over the stiffness
    const double burr = course.hand.poses.back().position.z() - course.scene.reference_point.z() + static_cast<double>(row.force.back()),
                 exact = drilled(2.5 - burr, 0.5);
    EXPECT_NEAR((row.swept.low + row.swept.high) / 2 / exact, 1, 0.01) << row.renderer;
  }
  EXPECT_NEAR(rows[0].removed / ((rows[0].swept.low + rows[0].swept.high) / 2), 1, 0.02);
  const nlohmann::ordered_json json = cuttingJson(rows, kEdge);
  EXPECT_EQ(json["schema"], "spheretree.cutting/1");
  EXPECT_EQ(json["rows"][1]["force_n"].size(), course.hand.poses.size());
  const std::string page = cuttingSection(rows), table = cuttingTable(rows);
  EXPECT_NE(page.find("force on the hand"), std::string::npos);
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 3);
}

TEST(CuttingComparison, RefusesWhatCannotBeCut) {
  builder::Progress progress;
  BodyLibrary bodies(builder::Quality::Quick, runtime::ContactSurface::Skin, progress);
  CuttingCourse course = cuttingBench(bodies, {3, 3, 2})[0];
  EXPECT_THROW(compareCutting(course, 0.001, progress), std::invalid_argument) << "too many voxels";
  course.scene.burr.clear();
  EXPECT_THROW(compareCutting(course, kEdge, progress), std::invalid_argument);
}

}  // namespace
}  // namespace spheretree::player
