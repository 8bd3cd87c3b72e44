// SPDX-License-Identifier: GPL-3.0-or-later
// Brute force for tests of the builders' coverage: many points of a surface, every sphere for each.
#pragma once

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include "base/ball.h"
#include "geometry/distance_field.h"
#include "spheretree/core/sphere.h"
#include "spheretree/core/triangle_mesh.h"
#include "support/random.h"

namespace spheretree::test {

/// Every corner and the middle of every side of every triangle, and `inner` random points in each.
inline std::vector<Eigen::Vector3d> densePoints(const TriangleMesh& mesh, int inner, std::uint64_t seed) {
  Random random(seed);
  std::vector<Eigen::Vector3d> points;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Eigen::Vector3d &a = mesh.corner(t, 0), &b = mesh.corner(t, 1), &c = mesh.corner(t, 2);
    points.insert(points.end(), {a, b, c, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)});
    for (int i = 0; i < inner; ++i) {
      double u = random.unit(), v = random.unit();
      if (u + v > 1) u = 1 - u, v = 1 - v;
      points.push_back(a + u * (b - a) + v * (c - a));
    }
  }
  return points;
}

/// Signed distance from a point to the union of balls: the smallest |p - c| - r.
inline double gapAt(const Eigen::Vector3d& p, std::span<const builder::Ball> balls) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const builder::Ball& b : balls) smallest = std::min(smallest, (p - b.centre).norm() - b.radius);
  return smallest;
}
inline double largestGap(std::span<const Eigen::Vector3d> points, std::span<const builder::Ball> balls) {
  double largest = -std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& p : points) largest = std::max(largest, gapAt(p, balls));
  return largest;
}

/// Stored spheres as balls in the frame of the mesh; exact for an origin of zero.
inline std::vector<builder::Ball> toBalls(std::span<const Sphere> spheres, const Eigen::Vector3d& origin = Eigen::Vector3d::Zero()) {
  std::vector<builder::Ball> balls;
  for (const Sphere& s : spheres) balls.push_back({Eigen::Vector3d(s.x, s.y, s.z) + origin, static_cast<double>(s.radius)});
  return balls;
}

/// Distance to the mesh, triangle by triangle.
inline double bruteDistance(const TriangleMesh& mesh, const Eigen::Vector3d& p) {
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    smallest = std::min(smallest, builder::nearestOnTriangle(p, mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)).distance);
  return smallest;
}

/// The mesh moved by `shift` [mm].
inline TriangleMesh moved(TriangleMesh mesh, const Eigen::Vector3d& shift) {
  for (Eigen::Vector3d& p : mesh.positions) p += shift;
  return mesh;
}

}  // namespace spheretree::test
