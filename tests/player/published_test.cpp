// SPDX-License-Identifier: GPL-3.0-or-later
// The published renderers and their parts, against closed forms. Subject: tools/haptic_player/published
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "comparison/comparison.h"
#include "published/ball_tree.h"
#include "published/distance_grid.h"
#include "published/inner_spheres.h"
#include "published/point_shell.h"
#include "published/static_coupling.h"
#include "scenarios/measures.h"
#include "support/random.h"
#include "support/scratch_folder.h"
#include "support/shapes.h"

namespace spheretree::player {
namespace {

using Eigen::Vector3d;
using test::Random;

Vector3d randomIn(Random& random, double half) {
  const double x = random.between(-half, half), y = random.between(-half, half), z = random.between(-half, half);
  return {x, y, z};
}

const Body& bodyOf(BodyLibrary& bodies, const std::string& name, TriangleMesh mesh) {
  builder::BuildSettings settings;
  settings.quality = builder::Quality::Quick;
  settings.levels = 3;
  return bodies.make(name, std::move(mesh), settings);
}

TEST(Modes, AreReadAndNamed) {
  EXPECT_EQ(modesOf("volume,paper,volume"), (std::vector{Mode::Published, Mode::Volume}));
  for (const Mode mode : kModes) EXPECT_EQ(modesOf(std::string(name(mode))), std::vector{mode});
  EXPECT_THROW(modesOf("paper,"), std::invalid_argument);
  EXPECT_THROW(modesOf("papers"), std::invalid_argument);
}

TEST(BallTree, FindsWhatBruteForceFinds) {
  Random random(3);
  std::vector<Vector3d> centres;
  std::vector<double> radii;
  for (int i = 0; i < 700; ++i) {
    centres.push_back(randomIn(random, 10));
    radii.push_back(random.between(0, 0.8));
  }
  const BallTree tree(centres, radii);
  for (int n = 0; n < 200; ++n) {
    const Vector3d p = randomIn(random, 12);
    const double reach = random.between(0, 2);
    std::vector<std::uint32_t> found, expected;
    tree.visit([&](const Vector3d& c, double r) { return (c - p).norm() < r + reach; },
               [&](std::uint32_t i) {
                 if ((centres[i] - p).norm() < radii[i] + reach) found.push_back(i);
               });
    for (std::uint32_t i = 0; i < centres.size(); ++i)
      if ((centres[i] - p).norm() < radii[i] + reach) expected.push_back(i);
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected);
  }
}

TEST(DistanceGrid, IsTheDistanceUpToItsCells) {
  const TriangleMesh mesh = test::sphereMesh(5, 4);
  const builder::DistanceField field(mesh);
  Random random(5);
  double last = 0.02;
  for (const std::size_t bytes : {40'000u, 400'000u, 4'000'000u}) {
    const DistanceGrid grid(field, bytes);
    EXPECT_LE(grid.byteCount(), bytes);
    double worst = 0, slope = 0;
    for (int n = 0; n < 3000; ++n) {
      const Vector3d p =
          randomIn(random, 1).normalized() * random.between(4, 5.2);  // far from the middle, where the field has a singular point
      const DistanceGrid::Sample sample = grid.at(p);
      worst = std::max(worst, std::abs(sample.distance - field.signedDistance(p)));
      slope = std::max(slope, (sample.gradient - p.normalized()).norm());
    }
    EXPECT_LT(worst, last) << bytes;
    EXPECT_LT(slope, 0.2);
    last = worst;
    for (int n = 0; n < 1000; ++n) {  // outside of the grid its value never exceeds the true distance
      const Vector3d p = randomIn(random, 1).normalized() * random.between(12, 40);
      EXPECT_LE(grid.at(p).distance, field.distance(p) + 1e-9);
    }
  }
  EXPECT_LT(last, 0.01);
}

TEST(DistanceGrid, GradientIsTheDerivative) {
  const TriangleMesh mesh = test::boxMesh({-3, -2, -1}, {3, 2, 1});
  const DistanceGrid grid(builder::DistanceField(mesh), 100'000);
  Random random(7);
  for (int n = 0; n < 500; ++n) {
    const Vector3d p = 0.9 * randomIn(random, 1).cwiseProduct(Vector3d(3, 2, 1));
    const double h = 1e-5;
    for (int k = 0; k < 3; ++k) {
      const Vector3d e = h * Vector3d::Unit(k);
      EXPECT_NEAR(grid.at(p).gradient[k], (grid.at(p + e).distance - grid.at(p - e).distance) / (2 * h), 1e-4);
    }
  }
}

TEST(InnerSpheres, FillTheBodyWithoutOverlap) {
  builder::Progress progress;
  BodyLibrary bodies(builder::Quality::Quick, runtime::ContactSurface::Skin, progress);
  const Body& body = bodyOf(bodies, "block_of_six", test::boxMesh({0, 0, 0}, {6, 4, 3}));
  double last = 0;
  for (const std::size_t count : {20u, 200u, 2000u}) {
    const InnerSpheres spheres(body, count);
    EXPECT_LE(spheres.centre.size(), count);
    double volume = 0;
    for (std::size_t i = 0; i < spheres.centre.size(); ++i) {
      EXPECT_LE(spheres.radius[i], -body.field.signedDistance(spheres.centre[i]) + 1e-9);
      volume += 4.0 / 3 * std::numbers::pi * std::pow(spheres.radius[i], 3);
      for (std::size_t j = 0; j < i; ++j)
        EXPECT_GE((spheres.centre[i] - spheres.centre[j]).norm(), spheres.radius[i] + spheres.radius[j] - 1e-9);
    }
    EXPECT_GT(volume, last) << "more spheres fill more";
    last = volume;
  }
  EXPECT_GT(last, 0.65 * 72) << "of the volume of the box";
  EXPECT_NEAR(InnerSpheres(body, 1).radius.at(0), 1.5, 0.05) << "the first is the largest inscribed ball";
}

TEST(StaticCoupling, ASpringOnASpringRestsBetweenThem) {
  // A wall of stiffness K at z = 0 under the reference point, a hand d below it: at rest the tool is d k / (k + K)
  // below.
  const runtime::Coupling coupling;
  const double stiffness = 9, depth = 0.5;
  Configuration graphic{{0, 0, 0}, {1, 0, 0, 0}};
  const Configuration haptic{{0.3, 0, -depth}, {1, 0, 0, 0}};
  for (int n = 0; n < 5; ++n) {
    Penalty penalty;
    penalty.add(Vector3d::Zero(), Vector3d::UnitZ(), -stiffness * graphic.position.z(), Vector3d::UnitZ(), stiffness);
    graphic = balanced(coupling, haptic, graphic, penalty);
  }
  EXPECT_NEAR(graphic.position.z(), -depth * coupling.translation / (coupling.translation + stiffness), 1e-12);
  EXPECT_NEAR(graphic.position.x(), 0.3, 1e-12) << "nothing holds it sideways";
}

TEST(ExactBall, IsTheClosedFormAtEdgeAndGroove) {
  const builder::DistanceField edge(test::boxMesh({-40, -40, -40}, {0, 40, 0}));
  ExactBall over_edge(edge, 1, {-3, 0, 1.2});
  for (int n = 0; n <= 400; ++n) {
    const double s = n / 400.0;
    const Vector3d hand(-3 + 4 * s, 0, 0.5 - 0.4 * s);
    EXPECT_LT((over_edge.follow(hand) - offsetEdge(hand, 1)).norm(), 2e-3) << hand.transpose();
  }
  const builder::DistanceField groove(BodyLibrary::mesh("groove"));
  ExactBall in_groove(groove, 1, {0, -2, 2.5});
  for (int n = 0; n <= 300; ++n) {
    const Vector3d hand(0.3 * std::sin(0.05 * n), -2 + 0.01 * n, 1.5);
    EXPECT_LT((in_groove.follow(hand) - offsetGroove(hand, 1, std::numbers::pi / 6)).norm(), 2e-3) << hand.transpose();
  }
}

class PublishedRenderers : public testing::TestWithParam<Mode> {};

TEST_P(PublishedRenderers, RestAtTheSurfaceAndLetGo) {
  builder::Progress progress;
  BodyLibrary bodies(builder::Quality::Quick, runtime::ContactSurface::Skin, progress);
  const Body &ball = bodyOf(bodies, "fine_ball", test::sphereMesh(2, 4)),
             &ground = bodyOf(bodies, "ground", test::boxMesh({-12, -12, -8}, {12, 12, 0}));
  const Configuration place{{5, -3, 2}, {std::sqrt(0.5), std::sqrt(0.5), 0, 0}};  // turned by 90 degrees about x: its top faces -y
  const auto renderer = makeRenderer(GetParam(), {&ball, Vector3d::Zero(), {{&ground, place}}, {}, 2'000'000});
  const auto at = [&](double height) { return Configuration{place.position + place.orientation * Vector3d(0, 0, height), {1, 0, 0, 0}}; };
  runtime::StepResult result = renderer->step(at(4));
  EXPECT_EQ(result.wrench.force.norm(), 0);
  for (double height = 4; height > 1; height -= 0.02) result = renderer->step(at(height));
  for (int n = 0; n < 200; ++n) result = renderer->step(at(1));
  const Vector3d up = place.orientation * Vector3d::UnitZ();
  EXPECT_NEAR(result.wrench.force.dot(up), 1, 0.35) << "1 mm below at 1 N/mm, less what a penalty gives way";
  EXPECT_LT((result.wrench.force - result.wrench.force.dot(up) * up).norm(), 0.2);
  for (double height = 1; height < 4; height += 0.02) result = renderer->step(at(height));
  EXPECT_LT(result.wrench.force.norm(), 1e-6);
  EXPECT_LT((result.graphic.position - at(4).position).norm(), 0.05);
  renderer->moveObject(0, {{100, 0, 0}, {1, 0, 0, 0}});
  renderer->restart();
  EXPECT_EQ(renderer->step(at(1)).wrench.force.norm(), 0) << "the ground is elsewhere";
}

INSTANTIATE_TEST_SUITE_P(All, PublishedRenderers, testing::Values(Mode::Points, Mode::Volume, Mode::Continuous),
                         [](const auto& tested) { return std::string(name(tested.param)); });

TEST(ContinuousRenderer, DoesNotPassWhatPenaltiesPass) {
  // In one step of 20 mm through a plate of 2 mm: the time of impact stops it, a penalty does not detect it.
  builder::Progress progress;
  BodyLibrary bodies(builder::Quality::Quick, runtime::ContactSurface::Skin, progress);
  const Body &ball = bodyOf(bodies, "fine_ball", test::sphereMesh(2, 4)),
             &plate = bodyOf(bodies, "plate_of_2", test::boxMesh({-12, -12, -2}, {12, 12, 0}));
  const auto depthOf = [&](Mode mode) {
    const auto renderer = makeRenderer(mode, {&ball, Vector3d::Zero(), {{&plate, {}}}, {}, 2'000'000});
    renderer->step({{0, 0, 8}, {1, 0, 0, 0}});
    return renderer->step({{0, 0, -12}, {1, 0, 0, 0}}).graphic.position.z();
  };
  EXPECT_GT(depthOf(Mode::Continuous), 1.8);
  EXPECT_LT(depthOf(Mode::Points), -5);
  EXPECT_LT(depthOf(Mode::Volume), -5);
}

TEST(Comparison, WritesOnePageOfAllRenderers) {
  const test::ScratchFolder folder;
  std::vector<ComparisonRow> rows;
  for (const Mode mode : kModes)
    for (const std::size_t leaves : {64u, 512u, 4096u})
      rows.push_back({mode, "edge", false, leaves, 1000, 3, 20, 0.01, 0.02, 0.03, 1, 2, 0.04});
  writeComparison(folder.path() / "page.html", rows, {}, {}, kModes);
  const auto size = std::filesystem::file_size(folder.path() / "page.html");
  EXPECT_GT(size, 10'000u);
  for (const bool on_leaves : {false, true})
    for (const std::size_t leaves : {8u, 64u})
      rows.push_back({Mode::Constrained, "edge", on_leaves, leaves, 1000, 3, 20, 0, 0, 0, 1, 2, 0});
  writeComparison(folder.path() / "page.html", rows, {}, {}, kModes);
  EXPECT_GT(std::filesystem::file_size(folder.path() / "page.html"), size + 2000);
}

}  // namespace
}  // namespace spheretree::player
