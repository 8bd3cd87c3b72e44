// SPDX-License-Identifier: GPL-3.0-or-later
// The exact answer for a tool, against closed forms, and the comparison of its models.
// Subject: comparison/exact_tool.h, comparison/tool_models.h
#include "comparison/tool_models.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "scenarios/measures.h"
#include "spheretree/builder/mesh_checks.h"
#include "support/random.h"

namespace spheretree::player {
namespace {

using Eigen::Vector3d;

const runtime::Coupling kCoupling;

TEST(NearestWithin, IsTheNearestPointOfThePolyhedron) {
  test::Random random(5);
  for (int n = 0; n < 300; ++n) {
    std::vector<std::pair<Scaled, double>> rows;
    for (std::size_t k = 1 + random.below(20); k > 0; --k) {
      Scaled a;
      a << random.direction(), random.between(-1, 1) * random.direction();
      rows.emplace_back(a, random.between(-0.5, 0.02));  // near 0, which is nearly feasible
    }
    Scaled target;
    target << random.direction(), random.direction();
    const std::optional<Scaled> y = nearestWithin(rows, target);
    ASSERT_TRUE(y);
    for (const auto& [a, b] : rows) EXPECT_GT(a.dot(*y) - b, -1e-8);
    // Optimal: no feasible point is on the target's side of the plane through y across the way to the target.
    for (int k = 0; k < 200; ++k) {
      Scaled other = *y;
      for (double& x : other) x += random.between(-0.3, 0.3);
      if (std::ranges::all_of(rows, [&](const auto& row) { return row.first.dot(other) >= row.second; })) {
        EXPECT_LT((target - *y).dot(other - *y), 1e-7);
      }
    }
  }
  Scaled up = Scaled::Zero();
  up[2] = 1;
  const std::vector<std::pair<Scaled, double>> contradiction{{up, 1.0}, {Scaled(-up), 0.0}};
  EXPECT_FALSE(nearestWithin(contradiction, Scaled::Zero()));
}

TEST(ExactTool, ABoxOnAPlateTurnsNoFartherThanTheCouplingBalances) {
  const SampledSolid tool(box({-2, -1, -0.5}, {2, 1, 0.5}), 0.25), plate(box({-20, -20, -5}, {20, 20, 0}), 2);
  const Vector3d reference(0, 0, 3);  // above the box, as a handle
  const auto upright = [](double z) { return Configuration{{0, 0, z}, {1, 0, 0, 0}}; };
  ExactTool exact(tool, plate, reference, kCoupling, upright(4));
  const Configuration flat = exact.follow(upright(3));
  EXPECT_NEAR(flat.position.z(), 3.5 + kExactGap, 1e-5) << "the lower face lies on the plate";
  EXPECT_LT(rotationVector(flat.orientation).norm(), 1e-5);
  // A hand that is turned about y presses an edge; the torque of the edge's force balances that of the coupling.
  const double angle = 0.02;
  const Configuration tilted = exact.follow({{0, 0, 3.2}, Quaternion(Eigen::AngleAxisd(angle, Vector3d::UnitY()))});
  const Displacement off = displacementBetween({{0, 0, 3.2}, Quaternion(Eigen::AngleAxisd(angle, Vector3d::UnitY()))}, tilted);
  const Vector3d force = kCoupling.translation * off.translation, torque = kCoupling.rotation * off.rotation;
  EXPECT_NEAR(force.x(), 0, 1e-4) << "no friction";
  const Vector3d arm = tilted.orientation * (Vector3d(2, 0, -0.5) - reference);  // to the edge that is lower
  EXPECT_NEAR((tilted.position + arm).z(), kExactGap, 1e-5);
  EXPECT_NEAR(torque.y(), -arm.cross(-force).y(), 2e-3 * torque.norm() + 1e-4);
}

TEST(ExactTool, ABallOverAnEdgeAndInAGrooveIsTheClosedForm) {
  builder::Progress progress;
  std::vector<ToolCourse> courses = toolBench(std::vector<std::string>{"ball", "edge", "groove"}, 0.3, progress);
  ASSERT_EQ(courses.size(), 2u);
  for (ToolCourse& course : courses) {
    for (std::size_t n = 0; 8 * n < course.hand.size(); ++n) course.hand[n] = course.hand[8 * n];
    course.hand.resize(course.hand.size() / 8);
    const std::vector<Configuration> answer = exactAnswer(course, kCoupling, progress);
    double largest = 0;
    for (std::size_t n = 0; n < answer.size(); ++n) {
      const Vector3d& hand = course.hand[n].position;
      const Vector3d right = course.body == "edge" ? offsetEdge(hand, 1) : offsetGroove(hand, 1, std::numbers::pi / 6);
      largest = std::max(largest, (answer[n].position - right).norm());
    }
    EXPECT_LT(largest, 6e-3) << course.body << ": kExactGap, and the facets of the ball";
  }
}

TEST(ToolBench, ItsMeshesAreSoundAndItsHandsGoAlong) {
  builder::Progress progress;
  std::vector<ToolCourse> courses = toolBench(std::vector<std::string>{"ball"}, 0.5, progress);
  for (ToolCourse& course : toolBench(std::vector<std::string>{"edge"}, 0.5, progress)) courses.push_back(std::move(course));
  EXPECT_EQ(courses.size(), 9u) << "each body, each tool";
  for (const ToolCourse& course : courses) {
    EXPECT_TRUE(builder::checkMesh(course.tool_mesh).clean()) << course.tool;
    EXPECT_TRUE(builder::checkMesh(course.body_mesh).clean()) << course.body;
    EXPECT_GT(course.hand.size(), 300u);
  }
  EXPECT_THROW(toolBench(std::vector<std::string>{"spoon"}, 0.5, progress), std::invalid_argument);
}

TEST(CompareTools, HasARowForEachModelAndMoreLeavesRestCloser) {
  tool::WorkProgress progress;
  BodyLibrary bodies(builder::Quality::Quick, runtime::ContactSurface::Skin, progress);
  std::vector<ToolCourse> courses = toolBench(std::vector<std::string>{"mirror", "edge"}, 0.3, progress);
  ASSERT_EQ(courses.size(), 1u);
  courses[0].hand.resize(120);
  const std::vector<ToolModel> all = toolModels(), models{all[1], all[2]};
  const std::vector<ToolRow> rows = compareTools(courses, models, bodies, progress);
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0].model, "exact");
  EXPECT_EQ(rows[0].parts, 0u);
  EXPECT_GT(rows[1].stand_off_p99, 2 * rows[2].stand_off_p99) << "64 and 512 leaves";
  EXPECT_GT(rows[1].force_p99, rows[2].force_p99);
  EXPECT_LT(rows[2].deepest, 1e-3);
  EXPECT_EQ(toolJson(rows)["rows"].size(), 3u);
  EXPECT_NE(toolTable(rows).find("512 leaves"), std::string::npos);
}

}  // namespace
}  // namespace spheretree::player
