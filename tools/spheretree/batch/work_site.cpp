// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/work_site.h"

#include <algorithm>

#include "geometry/distance_field.h"

namespace spheretree::tool {
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

std::vector<double> tolerancesAt(const WorkSite& site, const TriangleMesh& world_mesh, double tolerance_mm, double scale) {
  std::vector<builder::ToleranceRegion> regions;
  for (const formats::WorkRegion& region : site.regions) {
    regions.push_back(regionOf(region));
    regions.back().tolerance *= scale;
  }
  const std::vector<char> reached = site.space ? site.space->reached(world_mesh) : std::vector<char>();
  return builder::gradedTolerance(world_mesh, scale * tolerance_mm, regions, reached,
                                  scale * (site.reach ? site.reach->tolerance_mm : tolerance_mm));
}

nlohmann::ordered_json workFigures(const WorkSite& site, const TriangleMesh& mesh, const Configuration& pose, const SphereTree& tree) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  const TriangleMesh world = inWorld(mesh, pose);
  const Vector3d origin(tree.origin_mm[0], tree.origin_mm[1], tree.origin_mm[2]);
  const std::vector<std::uint32_t> leaves = levelSet(tree, tree.levelCount() - 1);
  for (const formats::WorkRegion& region : site.regions) {
    // Those triangles come into the region whose tolerance, from it alone, is next to nothing.
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
    double most = 0;
    for (const std::uint32_t leaf : leaves) {
      const Sphere& s = tree.cover[leaf];
      most = std::max(most, s.radius - field.distance(origin + Vector3d(s.x, s.y, s.z)));
    }
    out.push_back(
        {{"name", region.name}, {"tolerance_mm", region.tolerance_mm}, {"triangles", part.triangles.size()}, {"overhang_bound_mm", most}});
  }
  return out;
}

}  // namespace spheretree::tool
