// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/graded_tolerance.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "geometry/distance_field.h"
#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/builder/reachable_space.h"
#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

ToleranceRegion ballRegion(const Vector3d& centre, double radius, double tolerance) {
  ToleranceRegion region;
  region.centre = centre;
  region.radius = radius;
  region.tolerance = tolerance;
  return region;
}

TEST(GradedTolerance, GrowsHalfAsFastAsTheDistance) {
  const TriangleMesh mesh = test::sphereMesh(10, 4);
  const ToleranceRegion region = ballRegion({10, 0, 0}, 3, 0.05);
  const std::vector<double> tolerance = gradedTolerance(mesh, 1.0, {&region, 1}, {}, 0);
  for (std::size_t t = 0; t < tolerance.size(); ++t) {
    const double distance =
        std::max(0.0, nearestOnTriangle(region.centre, mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)).distance - 3);
    EXPECT_NEAR(tolerance[t], std::clamp(distance / 2, 0.05, 1.0), 1e-12);
  }
  EXPECT_EQ(*std::min_element(tolerance.begin(), tolerance.end()), 0.05);
  EXPECT_EQ(*std::max_element(tolerance.begin(), tolerance.end()), 1.0);
  // A box and unreachable surfaces; a region with a tolerance above that of the rest changes nothing.
  ToleranceRegion box;
  box.box = Eigen::AlignedBox3d(Vector3d(-20, -20, 9), Vector3d(20, 20, 20));
  box.tolerance = 0.1;
  std::vector<char> reached(mesh.triangles.size(), 1);
  for (std::size_t t = 0; t < reached.size(); ++t) reached[t] = mesh.corner(t, 0).z() > 0;
  const std::vector<ToleranceRegion> regions{box, ballRegion({0, 0, 10}, 5, 0.3)};
  const std::vector<double> graded = gradedTolerance(mesh, 0.2, regions, reached, 2.0);
  for (std::size_t t = 0; t < graded.size(); ++t) {
    if (mesh.corner(t, 0).z() > 9.5) {
      EXPECT_EQ(graded[t], 0.1);
    }
    if (mesh.corner(t, 0).z() < -9.5) {
      EXPECT_EQ(graded[t], 2.0);
    }
    if (reached[t]) {
      EXPECT_LE(graded[t], 0.2);
    }
  }
}

TEST(GradedTolerance, FieldWithSlackIsTheLeastOfDistanceAndSlack) {
  const TriangleMesh mesh = test::sphereMesh(10, 2);
  test::Random random(3);
  std::vector<double> slack(mesh.triangles.size());
  for (double& s : slack) s = random.between(0, 2);
  const DistanceField plain(mesh), graded(mesh, slack);
  for (int i = 0; i < 300; ++i) {
    const Vector3d p = random.inCube(14);
    double smallest = 1e9;
    for (std::size_t t = 0; t < slack.size(); ++t)
      smallest = std::min(smallest, nearestOnTriangle(p, mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)).distance + slack[t]);
    EXPECT_NEAR(std::abs(graded.signedDistance(p)), smallest, 1e-12);
    EXPECT_EQ(graded.signedDistance(p) < 0, plain.signedDistance(p) < 0);
  }
}

// The requirement itself, on the union of the leaves: in the region no point is farther out than its tolerance,
// elsewhere no farther than the general one.
TEST(GradedTolerance, HoldsInTheRegionAndElsewhere) {
  TriangleMesh mesh = test::boxMesh({-10, -10, -3}, {10, 10, 3});
  for (int round = 0; round < 4; ++round) mesh = test::quartered(std::move(mesh));
  const ToleranceRegion site = ballRegion({10, 10, 3}, 3, 0.3);
  BuildSettings settings;
  settings.quality = Quality::Quick;
  settings.tolerance_of_triangle_mm = gradedTolerance(mesh, 1.2, {&site, 1}, {}, 0);
  settings.tolerance_mm = 0.3;
  Progress progress;
  const BuildResult graded = buildSphereTree(mesh, settings, progress);
  EXPECT_TRUE(graded.statistics.tolerance_met);
  BuildSettings fine = settings;
  fine.tolerance_of_triangle_mm.clear();
  const BuildResult everywhere = buildSphereTree(mesh, fine, progress);
  EXPECT_GT(graded.tree.provenance.work_overhang_mm, 0.1f);
  EXPECT_LE(graded.tree.provenance.work_overhang_mm, 0.3f);
  EXPECT_EQ(everywhere.tree.provenance.work_overhang_mm, 0);
  EXPECT_LT(graded.statistics.levels.back().spheres, everywhere.statistics.levels.back().spheres * 3 / 4);

  const DistanceField field(mesh);
  test::Random random(4);
  double near_site = 0, elsewhere = 0;
  for (const std::uint32_t leaf : levelSet(graded.tree, graded.tree.levelCount() - 1)) {
    const Sphere& s = graded.tree.cover[leaf];
    for (int i = 0; i < 400; ++i) {
      const Vector3d p = Vector3d(s.x, s.y, s.z) + s.radius * random.direction();
      NearestPoint nearest;
      const double out = field.signedDistance(p, &nearest);
      const bool at_site = (nearest.point - site.centre).norm() < site.radius;
      EXPECT_LE(out, at_site ? 0.3 : 1.2);
      double& largest = at_site ? near_site : elsewhere;
      largest = std::max(largest, out);
    }
  }
  EXPECT_GT(near_site, 0.1);  // otherwise nothing was tested
  EXPECT_GT(elsewhere, 0.6);
}

TEST(GradedTolerance, IsRefusedWhereItMakesNoSense) {
  const TriangleMesh mesh = test::sphereMesh(10, 2);
  BuildSettings settings;
  Progress progress;
  settings.tolerance_of_triangle_mm.assign(mesh.triangles.size(), 0.5);
  EXPECT_THROW(buildSphereTree(mesh, settings, progress), std::invalid_argument);  // no tolerance
  settings.tolerance_mm = 0.6;
  EXPECT_THROW(buildSphereTree(mesh, settings, progress), std::invalid_argument);  // below the tolerance
  settings.tolerance_mm = 0.5;
  settings.tolerance_of_triangle_mm.pop_back();
  EXPECT_THROW(buildSphereTree(mesh, settings, progress), std::invalid_argument);
}

}  // namespace
}  // namespace spheretree::builder
