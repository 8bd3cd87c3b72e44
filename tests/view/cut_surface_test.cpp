// SPDX-License-Identifier: GPL-3.0-or-later
// The walls of a cavity against closed forms: cut_surface.h, removal.h, removal_replay.h
#include "model/cut_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "replay/removal_replay.h"

namespace spheretree::view {
namespace {

using Eigen::Vector3d;

/// The half-space z < 0, with another layer below z = -1.
std::shared_ptr<const CutMaterial> twoLayers() {
  return std::make_shared<const CutMaterial>(CutMaterial{{{"upper", {200, 200, 200, 255}, [](const Vector3d& p) { return -p.z(); }},
                                                          {"lower", {200, 0, 0, 255}, [](const Vector3d& p) { return -1 - p.z(); }}}});
}

struct Capsule {
  Vector3d from, to;
  double radius;
  double distance(const Vector3d& p) const {
    const Vector3d along = to - from;
    const double square = along.squaredNorm(), share = square > 0 ? std::clamp((p - from).dot(along) / square, 0.0, 1.0) : 0;
    return (p - from - share * along).norm() - radius;
  }
};

template <class Visit>
void visitCorners(const CutSurface& surface, Visit&& visit) {
  for (const auto& [place, entry] : surface.blocks())
    if (entry.block)
      for (const std::uint16_t corner : entry.block->triangles) visit(entry.block->corners[corner]);
}

/// Of the interpolation along an edge of a cell, h^2/8r, and of the mean of points within a cell, 3 h^2/8r.
double error(const CutSurface& surface, double radius) { return surface.spacing() * surface.spacing() / (2 * radius); }

TEST(CutSurface, OneWayIsACapsule) {
  CutSurface surface(twoLayers(), 0.5);
  const Capsule way{{0.1, 0.2, -1.3}, {2.05, 0.41, -1.1}, 0.5};
  EXPECT_TRUE(surface.empty());
  surface.remove(way.from, way.to, way.radius);
  std::size_t count = 0;
  visitCorners(surface, [&](const CutCorner& corner) {
    const Vector3d p = corner.position.cast<double>();
    ++count;
    EXPECT_LE(way.distance(p), 1e-5);
    EXPECT_GE(way.distance(p), -error(surface, way.radius));
    // The normal is that of the capsule, towards its axis, but for the mean within a cell.
    const Vector3d along = way.to - way.from;
    const double share = std::clamp((p - way.from).dot(along) / along.squaredNorm(), 0.0, 1.0);
    EXPECT_LT((corner.normal.cast<double>() + (p - way.from - share * along).normalized()).norm(), surface.spacing() / (2 * way.radius));
    EXPECT_EQ(corner.colour.g, p.z() > -1 + surface.spacing() / 2 ? 200 : p.z() < -1 - surface.spacing() / 2 ? 0 : corner.colour.g);
  });
  EXPECT_GT(count, 3000u);
}

TEST(CutSurface, TheWallIsClosed) {
  // Deep in the material: each edge of the wall of a ball is of two triangles, also across blocks.
  CutSurface surface(twoLayers(), 0.5);
  surface.remove({0.03, 0.01, -3}, {0.9, 0.2, -3.4}, 0.5);
  using Point = std::array<float, 3>;
  std::map<std::pair<Point, Point>, int> open;
  double volume = 0;
  for (const auto& [place, entry] : surface.blocks()) {
    if (!entry.block) continue;
    const auto& triangles = entry.block->triangles;
    for (std::size_t t = 0; t < triangles.size(); t += 3) {
      std::array<Point, 3> at;
      std::array<Vector3d, 3> p;
      for (std::size_t k = 0; k < 3; ++k) {
        const Eigen::Vector3f& q = entry.block->corners[triangles[t + k]].position;
        // Blocks have their corners in common but for the last bit.
        for (std::size_t axis = 0; axis < 3; ++axis) at[k][axis] = std::round(2e4f * q[static_cast<Eigen::Index>(axis)]);
        p[k] = q.cast<double>();
      }
      volume -= p[0].dot(p[1].cross(p[2])) / 6;  // counter-clockwise seen from within
      for (std::size_t k = 0; k < 3; ++k)
        if (at[k] != at[(k + 1) % 3]) {
          ++open[{at[k], at[(k + 1) % 3]}];
          --open[{at[(k + 1) % 3], at[k]}];
        }
    }
  }
  const double length = Vector3d(0.87, 0.19, -0.4).norm(), exact = M_PI * 0.25 * length + M_PI / 6;
  EXPECT_NEAR(volume, exact, 0.01 * exact);
  for (const auto& [edge, count] : open) EXPECT_EQ(count, 0);
}

TEST(CutSurface, CornersLieOnTheUnionOfAllWays) {
  CutSurface surface(twoLayers(), 0.4);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-0.8, 0.8);
  std::vector<Capsule> ways;
  Vector3d at(0, 0, -0.5);
  for (int n = 0; n < 60; ++n) {
    const Vector3d next(any(random), any(random), -0.6 + any(random) / 2);
    const double radius = n % 3 == 0 ? 0.4 : 0.5;
    ways.push_back({at, next, radius});
    surface.remove(at, next, radius);
    at = next;
  }
  std::size_t count = 0;
  double worst = 0;
  visitCorners(surface, [&](const CutCorner& corner) {
    const Vector3d p = corner.position.cast<double>();
    double nearest = 1;
    for (const Capsule& way : ways) nearest = std::min(nearest, way.distance(p));
    ++count;
    worst = std::max(worst, std::abs(nearest));
    // Where two ways meet in an edge, the wall cuts it off.
    EXPECT_LT(std::abs(nearest), surface.spacing());
    EXPECT_NEAR(static_cast<double>(corner.depth), std::min(-p.z() + surface.spacing() / 8, 2 * surface.spacing()),
                -p.z() < surface.spacing() ? 1e-4 : 20);
  });
  EXPECT_GT(count, 1000u);
  RecordProperty("worst_um", static_cast<int>(1000 * worst));
}

TEST(CutSurface, OnlyWhatTheBurrReachesChanges) {
  CutSurface surface(twoLayers(), 0.5);
  surface.remove({0, 0, -0.2}, {6, 0, -0.2}, 0.5);
  const CutSurface before = surface;
  (void)before.blocks();
  const Capsule way{{6, 0, -0.2}, {6, 0.1, -0.3}, 0.5};
  surface.remove(way.from, way.to, way.radius);
  std::size_t same = 0, changed = 0;
  const double side = surface.blockSide();
  for (const auto& [place, entry] : surface.blocks()) {
    const auto found = before.blocks().find(place);
    const bool is_same = found != before.blocks().end() && found->second.block == entry.block;
    (is_same ? same : changed) += 1;
    const Vector3d middle = side * (Vector3d(place[0], place[1], place[2]).array() + 0.5);
    EXPECT_TRUE(is_same || way.distance(middle) < 1.1 * side + 2 * surface.spacing());
  }
  EXPECT_GT(same, 3 * changed);
  EXPECT_GT(changed, 0u);
  // The same way again changes nothing.
  const CutSurface after = surface;
  surface.remove(way.from, way.to, way.radius);
  for (const auto& [place, entry] : surface.blocks()) EXPECT_EQ(entry.block, after.blocks().at(place).block);
  // Far outside of the material, nothing is kept.
  CutSurface free(twoLayers(), 0.5);
  free.remove({0, 0, 3}, {1, 0, 3}, 0.5);
  EXPECT_TRUE(free.empty());
}

/// A stage with one object of two layers, which a ball of 0.5 mm drills.
Stage drilledStage(bool is_cut) {
  Stage stage;
  stage.bodies.resize(2);
  stage.tool = 0;
  stage.objects = {{1, {{1, 2, 3}, {1, 0, 0, 0}}}};
  stage.burr = {{{0, 0, 1}, 0.5}};
  stage.reference_point = {0, 0, 1};
  if (is_cut) stage.objects[0].cut = twoLayers();
  return stage;
}

std::vector<player::RecordedStep> zigzag() {
  std::vector<player::RecordedStep> steps;
  for (std::uint64_t tick = 0; tick < 6000; ++tick) {
    player::RecordedStep step;
    step.tick = tick;
    step.time = 1e-3 * static_cast<double>(tick);
    step.graphic.position = Vector3d(1 + std::sin(2 * step.time), 2 + 0.2 * step.time, 2.6);
    step.spins = tick < 2500 || tick > 3500;
    steps.push_back(step);
  }
  return steps;
}

bool isSame(const Removal& a, const Removal& b) {
  const CutSurface::Blocks &p = a.of(0)->blocks(), &q = b.of(0)->blocks();
  return std::equal(p.begin(), p.end(), q.begin(), q.end(), [](const auto& x, const auto& y) {
    if (x.first != y.first || x.second.state != y.second.state) return false;
    return !x.second.block ||
           (x.second.block->distance == y.second.block->distance && x.second.block->triangles == y.second.block->triangles);
  });
}

TEST(RemovalReplay, JumpsGiveTheSameSurface) {
  const Stage stage = drilledStage(true);
  const std::vector<player::RecordedStep> steps = zigzag();
  const auto none = [](const player::RecordedStep&) { return std::vector<Configuration>(); };
  RemovalReplay replay(stage, steps, none);
  for (const std::size_t step : {0u, 1u, 700u, 5999u, 2499u, 2500u, 3501u, 999u, 1000u, 1001u, 0u, 4321u}) {
    const Removal* jumped = replay.at(step);
    ASSERT_NE(jumped, nullptr);
    Removal straight(stage);
    for (std::size_t n = 0; n <= step; ++n) straight.add(steps[n], {});
    EXPECT_TRUE(isSame(*jumped, straight)) << step;
  }
}

TEST(Removal, FollowsTheToolToAnEighthOfASpacing) {
  const Stage stage = drilledStage(true);
  Removal removal(stage);
  std::vector<Capsule> ways;
  Vector3d before = Vector3d::Zero();
  for (const player::RecordedStep& step : zigzag()) {
    const Vector3d at = step.graphic.position - Vector3d(1, 2, 3);  // of the ball, frame of the object
    removal.add(step, {});
    if (step.spins && step.tick > 0) ways.push_back({before, at, 0.5});
    before = at;
  }
  const double unseen = removal.of(0)->spacing() / 8;
  visitCorners(*removal.of(0), [&](const CutCorner& corner) {
    double nearest = 1;
    for (std::size_t n = 0; n < ways.size(); n += 4) nearest = std::min(nearest, ways[n].distance(corner.position.cast<double>()));
    EXPECT_LT(std::abs(nearest), removal.of(0)->spacing() / 2 + unseen);
  });
}

TEST(Removal, OfASceneWithoutCutIsEmpty) {
  Stage stage = drilledStage(false);
  EXPECT_TRUE(Removal(stage).empty());
  EXPECT_EQ(Removal(stage).of(0), nullptr);
  const std::vector<player::RecordedStep> steps = zigzag();
  bool was_asked = false;
  RemovalReplay replay(stage, steps, [&](const player::RecordedStep&) {
    was_asked = true;
    return std::vector<Configuration>();
  });
  EXPECT_EQ(replay.at(5999), nullptr);
  EXPECT_FALSE(was_asked);
  stage = drilledStage(true);
  stage.burr.clear();
  EXPECT_TRUE(Removal(stage).empty());
}

}  // namespace
}  // namespace spheretree::view
