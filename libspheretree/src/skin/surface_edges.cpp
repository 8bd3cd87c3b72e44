// SPDX-License-Identifier: GPL-3.0-or-later
#include "skin/surface_edges.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "mesh/mesh_edges.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

// As a share of the diagonal: a triangle farther from the plane is not part of a flat face. Positions in float have a
// relative error of 6e-8.
constexpr double kSkinFlatness = 1e-6;
// A flat face is wider than the adjacent groups by this factor. Triangles and quads of one regular mesh differ by up to
// 2.
constexpr double kFlatWidth = 3;
// Ratio of the longest side and the height of a long thin triangle. Subdivision surfaces fold where such triangles meet
// others, since their masks assume that the neighbours of a vertex are evenly distributed around it.
constexpr double kThin = 10;
// Adjacent needles take their normals from each other; sound meshes do not have more than two in a row.
constexpr int kNeedleRounds = 3;

struct MeanPlane {
  Vector3d area = Vector3d::Zero(), moment = Vector3d::Zero();  // sum of area vectors; of centroids, by area
  double weight = 0;
  void add(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    const Vector3d n = (b - a).cross(c - a);
    area += n, moment += n.norm() * (a + b + c) / 3, weight += n.norm();
  }
  double distance(const Vector3d& p) const { return std::abs(area.normalized().dot(p - moment / weight)); }
};

/// Coplanar triangles, and properties of their border.
struct PlanarGroup {
  std::vector<std::uint32_t> triangles;
  MeanPlane plane;
  double width = 0;  // twice the area divided by the length of the border: the width of a long strip
};

class EdgeClassifier {
 public:
  EdgeClassifier(const TriangleMesh& mesh, double crease_angle) : mesh_(mesh), cos_crease_(std::cos(crease_angle)) {
    Eigen::AlignedBox3d box;
    for (const Triangle& t : mesh.triangles)
      for (const std::uint32_t v : t) box.extend(mesh.positions[v]);
    flatness_ = kSkinFlatness * box.diagonal().norm();
  }

  SurfaceEdges run() {
    connect();
    findGroups();
    findFlatFaces();
    fixVertices();
    return std::move(out_);
  }

 private:
  void connect() {
    const std::size_t triangles = mesh_.triangles.size();
    out_.edge.assign(triangles, {kNoIndex, kNoIndex, kNoIndex});
    const std::vector<Side> sides = sortedSides(mesh_);
    std::vector<char> is_border;
    forEachEdge(sides, [&](std::size_t first, std::size_t last) {
      const auto e = static_cast<std::uint32_t>(out_.triangle.size());
      for (std::size_t i = first; i < last; ++i) out_.edge[sides[i].triangle][sides[i].corner] = e;
      out_.triangle.push_back({sides[first].triangle, last - first > 1 ? sides[first + 1].triangle : kNoIndex});
      is_border.push_back(last - first != 2 || sides[first].forward == sides[last - 1].forward);
    });
    findNormals();
    out_.kind.assign(out_.triangle.size(), EdgeKind::Smooth);
    for (std::size_t e = 0; e < out_.kind.size(); ++e) {
      const auto [s, t] = out_.triangle[e];
      if (is_border[e] || out_.triangle_normal[s].dot(out_.triangle_normal[t]) < cos_crease_) out_.kind[e] = EdgeKind::Sharp;
    }
  }

  // A needle, whose three vertices are collinear up to rounding, gets the normal of the triangle across its longest
  // side: its own normal would be random, and would cause spurious creases.
  void findNormals() {
    const std::size_t triangles = mesh_.triangles.size();
    out_.triangle_normal.assign(triangles, Vector3d::Zero());
    std::vector<std::uint32_t> needles;
    for (std::uint32_t t = 0; t < triangles; ++t) {
      const Vector3d n = areaVector(t);
      if (n.norm() > flatness_ * longestSide(t))
        out_.triangle_normal[t] = n.normalized();
      else
        needles.push_back(t);
    }
    for (int round = 0; round < kNeedleRounds && !needles.empty(); ++round)
      for (const std::uint32_t t : needles) {
        std::size_t longest = 0;
        for (std::size_t side = 1; side < 3; ++side)
          if (length(t, side) > length(t, longest)) longest = side;
        if (const std::uint32_t next = across(t, longest); next != kNoIndex && out_.triangle_normal[t].isZero(0))
          out_.triangle_normal[t] = out_.triangle_normal[next];
      }
  }

  /// Its length is twice the area.
  Vector3d areaVector(std::uint32_t t) const {
    return (mesh_.corner(t, 1) - mesh_.corner(t, 0)).cross(mesh_.corner(t, 2) - mesh_.corner(t, 0));
  }
  double longestSide(std::uint32_t t) const { return std::max({length(t, 0), length(t, 1), length(t, 2)}); }

  double length(std::uint32_t t, std::size_t side) const {
    return (mesh_.corner(t, static_cast<int>((side + 1) % 3)) - mesh_.corner(t, static_cast<int>(side))).norm();
  }

  std::uint32_t across(std::uint32_t t, std::size_t side) const {
    const auto& both = out_.triangle[out_.edge[t][side]];
    return both[0] == t ? both[1] : both[0];
  }

  // Grows groups from the largest triangles. The plane is that of all triangles so far, since the plane of one small
  // triangle would be uncertain far from it.
  void findGroups() {
    const std::size_t triangles = mesh_.triangles.size();
    std::vector<double> area(triangles);
    for (std::uint32_t t = 0; t < triangles; ++t) area[t] = areaVector(t).norm();
    std::vector<std::uint32_t> order(triangles);
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return area[a] > area[b] || (area[a] == area[b] && a < b); });
    group_.assign(triangles, kNoIndex);
    for (const std::uint32_t seed : order)
      if (group_[seed] == kNoIndex) grow(seed, area[seed] > 0);
    for (std::uint32_t g = 0; g < groups_.size(); ++g) groups_[g].width = widthOf(g);
  }

  void take(std::uint32_t t, std::uint32_t g) {
    group_[t] = g;
    groups_[g].triangles.push_back(t);
    groups_[g].plane.add(mesh_.corner(t, 0), mesh_.corner(t, 1), mesh_.corner(t, 2));
  }

  void grow(std::uint32_t seed, bool has_area) {
    const auto g = static_cast<std::uint32_t>(groups_.size());
    groups_.emplace_back();
    take(seed, g);
    if (!has_area) return;
    for (std::size_t i = 0; i < groups_[g].triangles.size(); ++i) {
      const std::uint32_t t = groups_[g].triangles[i];
      for (std::size_t side = 0; side < 3; ++side) {
        if (out_.isSharp(out_.edge[t][side])) continue;
        const std::uint32_t next = across(t, side);
        if (next == kNoIndex || group_[next] != kNoIndex || !fits(next, groups_[g].plane)) continue;
        take(next, g);
      }
    }
    // The plane has moved while the group grew.
    PlanarGroup& group = groups_[g];
    const bool is_flat =
        std::all_of(group.triangles.begin(), group.triangles.end(), [&](std::uint32_t t) { return fits(t, group.plane, 2); });
    if (is_flat) return;
    for (std::size_t i = 1; i < group.triangles.size(); ++i) group_[group.triangles[i]] = kNoIndex;
    groups_[g] = {};
    take(seed, g);
  }

  bool fits(std::uint32_t t, const MeanPlane& plane, double times = 1) const {
    for (int k = 0; k < 3; ++k)
      if (!(plane.distance(mesh_.corner(t, k)) <= times * flatness_)) return false;
    return out_.triangle_normal[t].dot(plane.area) >= 0;
  }

  // Calls visit(triangle, side, neighbour or kNoIndex) for the sides around a group.
  template <class Visit>
  void forEachBorder(std::uint32_t g, Visit&& visit) const {
    for (const std::uint32_t t : groups_[g].triangles)
      for (std::size_t side = 0; side < 3; ++side)
        if (const std::uint32_t next = across(t, side); next == kNoIndex || group_[next] != g) visit(t, side, next);
  }

  double widthOf(std::uint32_t g) const {
    double border = 0;
    forEachBorder(g, [&](std::uint32_t t, std::size_t side, std::uint32_t) { border += length(t, side); });
    return border > 0 ? groups_[g].plane.weight / border : 0;  // the weight is twice the area
  }

  void findFlatFaces() {
    out_.flat_face.assign(mesh_.triangles.size(), kNoIndex);
    for (std::uint32_t g = 0; g < groups_.size(); ++g) {
      bool is_flat = groups_[g].plane.weight > 0, is_enclosed = true;
      forEachBorder(g, [&](std::uint32_t t, std::size_t side, std::uint32_t next) {
        if (out_.isSharp(out_.edge[t][side])) return;
        is_enclosed = false;
        is_flat = is_flat && groups_[group_[next]].width * kFlatWidth <= groups_[g].width;
      });
      if (!is_flat || (groups_[g].triangles.size() < 2 && !is_enclosed)) continue;
      for (const std::uint32_t t : groups_[g].triangles) out_.flat_face[t] = static_cast<std::uint32_t>(out_.face_normal.size());
      out_.face_normal.push_back(groups_[g].plane.area.normalized());
    }
  }

  bool isThin(std::uint32_t t) const {
    const double longest = longestSide(t);
    return longest * longest > kThin * areaVector(t).norm();  // the height is twice the area divided by the longest side
  }

  void fixVertices() {
    out_.is_fixed.assign(mesh_.positions.size(), 0);
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      const Triangle& corners = mesh_.triangles[t];
      const bool is_stiff = out_.flat_face[t] != kNoIndex || isThin(t);
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t e = out_.edge[t][k];
        if (is_stiff || out_.isSharp(e)) out_.is_fixed[corners[k]] = out_.is_fixed[corners[(k + 1) % 3]] = 1;
        if (is_stiff && !out_.isSharp(e)) out_.kind[e] = EdgeKind::Straight;
      }
    }
  }

  const TriangleMesh& mesh_;
  double cos_crease_;
  double flatness_ = 0;  // [mm]
  SurfaceEdges out_;
  std::vector<std::uint32_t> group_;  // (triangles)
  std::vector<PlanarGroup> groups_;
};

}  // namespace

SurfaceEdges classifyEdges(const TriangleMesh& mesh, double crease_angle) { return EdgeClassifier(mesh, crease_angle).run(); }

}  // namespace spheretree::builder
