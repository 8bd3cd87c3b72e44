// SPDX-License-Identifier: GPL-3.0-or-later
// Exact distance from points to a triangle mesh, which every stage of a build and every measure uses.
//
// The sign comes from the angle-weighted pseudonormal of the nearest feature. Paper: J. A. Baerentzen, H. Aanaes.
// Signed distance computation using the angle weighted pseudonormal. IEEE TVCG 11(3), 2005. It is correct for every
// closed, oriented, manifold mesh without self-intersections, which mesh_checks.h checks. Sheets (surface with nothing
// solid on either side) count as surface for distances, but do not affect the sign.
// This is our own code instead of CGAL's AABB tree, because a build makes half a million queries, and that tree takes
// 13 us for a query where this one takes 1 us.
// Units: mm, frame of the mesh. Double precision: a distance is accurate to 1e-13 of the largest coordinate; for a
// triangle in which the sine of some corner is below 1e-4, to 1e-8 of the distance.
#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <span>
#include <vector>

#include "geometry/box_tree.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct NearestPoint {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();            // on the surface [mm]
  double distance = std::numeric_limits<double>::infinity();  // >= 0, includes the slack of its triangle [mm]
  double slack = 0;                                           // of its triangle [mm]
  std::uint32_t triangle = 0;                                 // index into the mesh given to the constructor; the sheets follow
  std::uint8_t feature = 0;                                   // 0 face; 1..3 edge opposite corner 0..2; 4..6 corner 0..2
  std::uint32_t tested = 0;                                   // triangles tested: the cost of the query, the same on every machine
};

/// Nearest point of triangle a, b, c to p; fills point, distance and feature. Also correct for degenerate triangles.
NearestPoint nearestOnTriangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

class DistanceField {
 public:
  DistanceField() = default;  // without triangles: all distances are infinite
  /// O(n log n). Copies what it needs. @throws std::invalid_argument for a mesh without triangles.
  /// `slack`: one length >= 0 for each triangle, or empty [mm]. It is added to every distance to that triangle, so that
  /// a ball whose radius is limited by its distance may reach out by that much more there. This gives places of a
  /// surface tolerances of their own (graded_tolerance.h).
  /// `sheets`: triangles outside the solid that also belong to the surface, without slack; any number, with any
  /// winding.
  explicit DistanceField(const TriangleMesh& mesh, std::span<const double> slack = {}, const TriangleMesh& sheets = {});

  /// The nearest surface point with a distance below `limit`; if there is none, `distance` is infinite. On ties the
  /// lower triangle is chosen.
  NearestPoint nearest(const Eigen::Vector3d& p, double limit = std::numeric_limits<double>::infinity()) const;
  double distance(const Eigen::Vector3d& p) const { return nearest(p).distance; }
  /// Calls visit(triangle) for each triangle within `radius` of `p`, and possibly for some farther ones, in a fixed
  /// order.
  template <class Visit>
  void visitNear(const Eigen::Vector3d& p, double radius, Visit&& visit) const {
    tree_.searchWithin(p, radius * radius, [&](std::size_t first, std::size_t count) {
      for (std::size_t slot = first; slot < first + count; ++slot) visit(tree_.order()[slot]);
    });
  }
  /// Distance to the surface, negative inside the solid [mm].
  double signedDistance(const Eigen::Vector3d& p, NearestPoint* nearest_out = nullptr) const;
  /// Whether `p` is inside, given its nearest surface point. With slack, the point that is nearest without slack is
  /// searched for first.
  bool isInside(const Eigen::Vector3d& p, const NearestPoint& nearest) const;

  /// Unit normal of a triangle; zero for a degenerate one.
  const Eigen::Vector3d& normal(std::uint32_t triangle) const { return normal_[triangle]; }
  const std::array<Eigen::Vector3d, 3>& corners(std::uint32_t triangle) const { return corners_[slot_[triangle]]; }
  /// Angle-weighted pseudonormal (unit) at a nearest point, of its face, edge or corner; on a sheet, the normal of its
  /// triangle.
  Eigen::Vector3d pseudonormal(const NearestPoint& nearest) const;
  /// The triangle of the solid that runs along the side from corner `k` to the next the other way round, if it is the
  /// only other triangle there; else kNoTriangle.
  std::uint32_t across(std::uint32_t triangle, std::size_t k) const;
  static constexpr std::uint32_t kNoTriangle = std::numeric_limits<std::uint32_t>::max();

  const Eigen::AlignedBox3d& box() const { return box_; }
  double diagonal() const { return diagonal_; }
  double area() const { return area_; }      // of the solid [mm^2]
  double volume() const { return volume_; }  // by the divergence theorem about the box centre [mm^3]
  std::size_t triangleCount() const { return slot_.size(); }

 private:
  void placeFaces(const TriangleMesh& mesh, std::span<const double> slack, const TriangleMesh& sheets);
  template <bool with_slack, bool with_sheets>
  NearestPoint search(const Eigen::Vector3d& p, double limit) const;
  void findPseudonormals(const TriangleMesh& mesh);
  /// Calls visit(triangle, k) for each side of the solid between corners `a` and `b`, by triangle, then by k.
  template <class Visit>
  void visitSides(std::uint32_t a, std::uint32_t b, Visit&& visit) const;
  bool has_slack_ = false;
  std::size_t solid_ = 0;  // triangles of the mesh; the sheets follow
  BoxTree tree_;
  std::vector<std::array<Eigen::Vector3d, 3>> corners_;  // (slots)
  std::vector<double> slack_;                            // (slots), or empty
  std::vector<Eigen::Vector3d> normal_;                  // by triangle
  std::vector<std::uint32_t> slot_;                      // by triangle
  std::vector<Triangle> corner_;                         // by triangle of the mesh: its vertices, those at one position as one
  std::vector<std::uint32_t> first_around_;              // (vertices + 1) where its part of around_ begins
  std::vector<std::uint32_t> around_;                    // corners at each vertex, ascending: 3 times the triangle plus the corner
  std::vector<Eigen::Vector3d> at_vertex_;               // pseudonormals
  Eigen::AlignedBox3d box_;
  double diagonal_ = 0, area_ = 0, volume_ = 0;
};

}  // namespace spheretree::builder
