// SPDX-License-Identifier: GPL-3.0-or-later
// Any tolerance and any number of leaves end with a sound tree, or with a reason in a BuildError: on shapes whose
// coarse levels are as good as their leaves, or nearly so, too. SPHERETREE_LONG=1: every case (a quarter of an hour) in
// place of a few.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "geometry/distance_field.h"
#include "spheretree/builder/build_sphere_tree.h"
#include "support/shapes.h"

namespace spheretree {
namespace {

// The solid that a profile of (radius, height) encloses when it turns about the z axis, from the bottom to the top; the
// first and the last radius are 0.
TriangleMesh turned(const std::vector<std::pair<double, double>>& profile, std::uint32_t around) {
  TriangleMesh mesh;
  const auto rings = static_cast<std::uint32_t>(profile.size() - 2);
  mesh.positions.emplace_back(0, 0, profile.front().second);
  for (std::uint32_t ring = 1; ring <= rings; ++ring)
    for (std::uint32_t i = 0; i < around; ++i) {
      const double angle = 2 * std::numbers::pi * i / around;
      mesh.positions.emplace_back(profile[ring].first * std::cos(angle), profile[ring].first * std::sin(angle), profile[ring].second);
    }
  mesh.positions.emplace_back(0, 0, profile.back().second);
  const auto at = [&](std::uint32_t ring, std::uint32_t i) { return 1 + (ring - 1) * around + i % around; };
  for (std::uint32_t i = 0; i < around; ++i) {
    mesh.triangles.push_back({0, at(1, i + 1), at(1, i)});
    for (std::uint32_t ring = 1; ring < rings; ++ring) {
      mesh.triangles.push_back({at(ring, i), at(ring, i + 1), at(ring + 1, i + 1)});
      mesh.triangles.push_back({at(ring, i), at(ring + 1, i + 1), at(ring + 1, i)});
    }
    mesh.triangles.push_back({at(rings, i), at(rings, i + 1), 1 + rings * around});
  }
  return mesh;
}

// An arc of a circle about a point on the axis; `squeeze` scales its height.
std::vector<std::pair<double, double>> arc(double radius, double squeeze, int steps) {
  std::vector<std::pair<double, double>> profile;
  for (int i = 0; i <= steps; ++i) {
    const double angle = std::numbers::pi * i / steps;
    profile.emplace_back(i % steps == 0 ? 0 : radius * std::sin(angle), -squeeze * radius * std::cos(angle));
  }
  return profile;
}

struct Shape {
  const char* name;
  TriangleMesh mesh;
};

std::vector<Shape> shapes() {
  return {{"ball of quads", turned(arc(3, 1, 24), 48)},
          {"ball", test::sphereMesh(1, 3)},
          {"octahedron", test::sphereMesh(1, 0)},
          {"lens", turned(arc(5, 0.1, 16), 32)},
          {"spindle", turned(arc(1, 8, 16), 12)},
          {"cylinder", turned({{0, 0}, {1, 0}, {1, 6}, {0, 6}}, 24)},
          {"disc", turned({{0, 0}, {4, 0}, {4, 0.2}, {0, 0.2}}, 24)},
          {"cone", turned({{0, 0}, {2, 0}, {0.5, 3}, {0, 4}}, 20)},
          {"cube", test::boxMesh({0, 0, 0}, {1, 1, 1})},
          {"rod", test::boxMesh({0, 0, 0}, {20, 1, 1})},
          {"torus", test::torusMesh(5, 1, 24, 10)}};
}

// Builds, and says what is wrong, or nothing.
std::string faultOf(const TriangleMesh& mesh, const builder::BuildSettings& settings) {
  builder::Progress progress;
  try {
    const builder::BuildResult result = builder::buildSphereTree(mesh, settings, progress);
    if (settings.tolerance_mm > 0 && result.statistics.tolerance_met &&
        result.statistics.levels.back().overhang_bound_mm > settings.tolerance_mm)
      return "the tolerance is said to be met, but is not";
    if (settings.max_leaves > 0 &&
        levelSet(result.tree, result.tree.levelCount() - 1).size() > static_cast<std::size_t>(settings.max_leaves))
      return "more leaves than asked for";
    return findFault(result.tree);
  } catch (const builder::BuildError&) {
    return {};
  } catch (const std::exception& error) {
    return error.what();
  }
}

TEST(EveryTolerance, EndsWithATreeOrAReason) {
  const bool is_long = std::getenv("SPHERETREE_LONG") != nullptr;
  std::size_t number = 0;
  for (const auto& [name, mesh] : shapes()) {
    const double diagonal = builder::DistanceField(mesh).diagonal();
    const auto expectTree = [&](const builder::BuildSettings& settings) {
      if (!is_long && number++ % 5 != 0) return;
      SCOPED_TRACE(std::string(name) + ", " + std::string(builder::name(settings.builder)) + ", tolerance " +
                   std::to_string(settings.tolerance_mm) + " mm, leaves " + std::to_string(settings.max_leaves) + ", levels " +
                   std::to_string(settings.levels) + ", branching " + std::to_string(settings.branching));
      EXPECT_EQ(faultOf(mesh, settings), "");
    };
    builder::BuildSettings settings;
    settings.quality = builder::Quality::Quick;
    settings.skin = false;
    for (const builder::BuilderKind kind : {builder::BuilderKind::Cover, builder::BuilderKind::Merge})
      for (int step = 0; step < (is_long ? 12 : 5); ++step) {  // from a twentieth to a ten-thousandth of the diagonal
        settings.builder = kind;
        settings.tolerance_mm = diagonal / 20 * std::pow(500, -step / 11.0);
        settings.levels = step % 3 == 0 ? 5 : 4;
        settings.branching = step % 4 == 3 ? 3 : 8;
        expectTree(settings);
      }
    settings = {};
    settings.quality = builder::Quality::Quick;
    settings.skin = false;
    for (const int leaves : {1, 2, 7, 8, 9, 17, 63, 65, 200, 512}) {
      if (leaves > 65 && !is_long) break;
      settings.max_leaves = leaves;
      expectTree(settings);
    }
    settings.levels = 5;
    settings.max_leaves = 1000;
    if (is_long) expectTree(settings);
  }
}

// Leaves took the places of spheres of level 1, which needed them when level 2 grew to hold the leaves' parents.
TEST(EveryTolerance, LeavesThatMoveUpLeaveRoomForLevelsThatGrow) {
  builder::BuildSettings settings;
  settings.quality = builder::Quality::Quick;
  settings.skin = false;
  settings.tolerance_mm = 0.00566;
  EXPECT_EQ(faultOf(turned(arc(3, 1, 24), 48), settings), "");
}

}  // namespace
}  // namespace spheretree
