// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/batch/work_regions.h"

#include <algorithm>

#include "geometry/distance_field.h"

namespace spheretree::pipeline {
namespace {

using Eigen::Vector3d;

builder::ToleranceRegion regionOf(const formats::WorkRegion& region) {
  builder::ToleranceRegion out;
  out.tolerance = region.tolerance_mm;
  out.centre = region.centre_mm;
  out.radius = region.shape == formats::WorkRegion::Shape::Sphere ? region.radius_mm : 0;
  if (region.shape == formats::WorkRegion::Shape::Box) out.box = Eigen::AlignedBox3d(region.low_mm, region.high_mm);
  return out;
}

}  // namespace

TriangleMesh inWorld(TriangleMesh mesh, const Configuration& pose) {
  const Eigen::Matrix3d turn = pose.orientation.toRotationMatrix();
  for (Vector3d& p : mesh.positions) p = pose.position + turn * p;
  return mesh;
}

double distanceOf(const formats::WorkRegion& region, const Eigen::AlignedBox3d& world_box) {
  const builder::ToleranceRegion place = regionOf(region);
  return place.radius > 0 ? world_box.exteriorDistance(place.centre) - place.radius : world_box.exteriorDistance(place.box);
}

std::vector<formats::WorkRegion> regionsInRange(const WorkRegions& work, const Eigen::AlignedBox3d& world_box, double tolerance_mm,
                                                double scale) {
  const double largest = scale * std::max(tolerance_mm, work.reach ? work.reach->tolerance_mm : 0);
  std::vector<formats::WorkRegion> out;
  for (const formats::WorkRegion& region : work.regions)
    if (distanceOf(region, world_box) <= builder::regionRange(largest)) out.push_back(region);
  return out;
}

std::vector<double> tolerancesAt(const WorkRegions& work, std::span<const formats::WorkRegion> regions, const TriangleMesh& world_mesh,
                                 double tolerance_mm, double scale) {
  std::vector<builder::ToleranceRegion> scaled;
  for (const formats::WorkRegion& region : regions) {
    scaled.push_back(regionOf(region));
    scaled.back().tolerance *= scale;
  }
  const std::vector<char> reached = work.space ? work.space->reached(world_mesh) : std::vector<char>();
  return builder::gradedTolerance(world_mesh, scale * tolerance_mm, scaled, reached,
                                  scale * (work.reach ? work.reach->tolerance_mm : tolerance_mm));
}

std::vector<WorkFigures> workFigures(std::span<const formats::WorkRegion> regions, const TriangleMesh& mesh, const Configuration& pose,
                                     const SphereTree& tree) {
  std::vector<WorkFigures> out;
  const TriangleMesh world = inWorld(mesh, pose);
  const Vector3d origin(tree.origin_mm[0], tree.origin_mm[1], tree.origin_mm[2]);
  const std::vector<std::uint32_t> leaves = levelSet(tree, tree.levelCount() - 1);
  for (const formats::WorkRegion& region : regions) {
    // A triangle is in the region if this region alone would give it a tolerance of almost zero.
    constexpr double kNone = 1e-9;
    builder::ToleranceRegion only = regionOf(region);
    only.tolerance = kNone;
    const std::vector<double> inside = builder::gradedTolerance(world, 1e9, {&only, 1}, {}, 0);
    TriangleMesh part;
    part.positions = mesh.positions;
    for (std::size_t t = 0; t < inside.size(); ++t)
      if (inside[t] <= kNone) part.triangles.push_back(mesh.triangles[t]);
    if (part.triangles.empty()) continue;
    const builder::DistanceField field(part);
    double largest = 0;
    for (const std::uint32_t leaf : leaves) {
      const Sphere& s = tree.cover[leaf];
      largest = std::max(largest, s.radius - field.distance(origin + centreOf(s)));
    }
    out.push_back({region.name, region.tolerance_mm, part.triangles.size(), largest});
  }
  return out;
}

}  // namespace spheretree::pipeline
