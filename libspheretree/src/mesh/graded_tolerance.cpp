// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/graded_tolerance.h"

#include <algorithm>

#include "geometry/distance_field.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kGrowth = 0.5;  // growth of a tolerance with the distance

// A lower bound of the distance: for a box, the distance to the bounding box of the triangle.
double distanceTo(const ToleranceRegion& region, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  if (region.radius > 0) return std::max(0.0, nearestOnTriangle(region.centre, a, b, c).distance - region.radius);
  Eigen::AlignedBox3d box(a);
  box.extend(b).extend(c);
  return region.box.exteriorDistance(box);
}

TriangleMesh reachedPart(const TriangleMesh& mesh, std::span<const char> reached) {
  TriangleMesh part;
  part.positions = mesh.positions;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (reached[t]) part.triangles.push_back(mesh.triangles[t]);
  return part;
}

}  // namespace

double regionRange(double tolerance) { return tolerance / kGrowth; }

std::vector<double> gradedTolerance(const TriangleMesh& mesh, double tolerance, std::span<const ToleranceRegion> regions,
                                    std::span<const char> reached, double unreached_tolerance) {
  const std::size_t count = mesh.triangles.size();
  std::vector<double> out(count, tolerance);
  if (!reached.empty() && unreached_tolerance > tolerance) {
    const TriangleMesh part = reachedPart(mesh, reached);
    const bool any = !part.triangles.empty();
    const DistanceField field = any ? DistanceField(part) : DistanceField();
    for (std::size_t t = 0; t < count; ++t) {
      if (reached[t]) continue;
      out[t] = unreached_tolerance;
      if (!any) continue;
      const Vector3d middle = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3;
      double extent = 0;
      for (int k = 0; k < 3; ++k) extent = std::max(extent, (mesh.corner(t, k) - middle).norm());
      const double distance = std::max(0.0, field.distance(middle) - extent);
      out[t] = std::min(unreached_tolerance, std::max(tolerance, kGrowth * distance));
    }
  }
  for (const ToleranceRegion& region : regions)
    for (std::size_t t = 0; t < count; ++t)
      out[t] = std::min(out[t],
                        std::max(region.tolerance, kGrowth * distanceTo(region, mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2))));
  return out;
}

}  // namespace spheretree::builder
