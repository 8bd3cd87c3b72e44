// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/untangle_scan.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mesh/crossing_triangles.h"
#include "spheretree/builder/mesh_checks.h"
#include "split/crossing_search.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr int kUntangleRounds = 30;  // rounds of moving
constexpr double kMaxNoise = 3;      // largest motion, in standard deviations of the noise
constexpr int kUntangledRings = 2;   // rings around the crossing triangles whose vertices may move

class Untangling {
 public:
  explicit Untangling(ScanSurface& s)
      : mesh_(s.mesh), origin_(s.mesh.positions), neighbours_(s.mesh), search_(s.mesh.positions, meanEdge(s)) {}

  MovedVertices run() {
    std::vector<std::uint32_t> corners;
    for (const auto& [a, b] : findCrossingTriangles(mesh_, kMaxCrossingPairs).pairs)
      for (const std::uint32_t t : {a, b}) corners.insert(corners.end(), mesh_.triangles[t].begin(), mesh_.triangles[t].end());
    if (corners.empty()) return {};
    findMovable(corners);
    const double largest = kMaxNoise * noise();
    for (int round = 0; round < kUntangleRounds; ++round) {
      const std::vector<char> is_crossing = crossingVertices();
      if (std::find(is_crossing.begin(), is_crossing.end(), 1) == is_crossing.end()) break;
      std::vector<Vector3d> next = mesh_.positions;
      for (std::uint32_t v = 0; v < next.size(); ++v) {
        if (!is_crossing[v]) continue;
        const Vector3d way = (mesh_.positions[v] + meanOfNeighbours(v)) / 2 - origin_[v];
        next[v] = origin_[v] + (way.norm() > largest ? largest / way.norm() : 1) * way;
      }
      mesh_.positions.swap(next);
    }
    return moved();
  }

 private:
  void findMovable(const std::vector<std::uint32_t>& corners) {
    is_movable_.assign(mesh_.positions.size(), 0);
    for (const std::uint32_t v : corners) is_movable_[v] = 1;
    for (const std::uint32_t t : trianglesNear(mesh_, corners, kUntangledRings))
      for (const std::uint32_t v : mesh_.triangles[t]) is_movable_[v] = 1;
    for (const Triangle& t : mesh_.triangles) {
      if (is_movable_[t[0]] || is_movable_[t[1]] || is_movable_[t[2]])
        moving_.push_back(t);
      else
        search_.add(t);
    }
  }

  /// The vertices that may move and that belong to a triangle which crosses another one now.
  std::vector<char> crossingVertices() const {
    const auto still = static_cast<std::uint32_t>(search_.triangles().size());
    std::vector<char> is_crossing(mesh_.positions.size(), 0);
    for (const auto& [a, b] : search_.against(moving_))
      for (const std::uint32_t t : {a, b})
        if (t >= still)
          for (const std::uint32_t v : moving_[t - still]) is_crossing[v] = is_movable_[v];
    return is_crossing;
  }

  Vector3d meanOfNeighbours(std::uint32_t v) const {
    Vector3d sum = Vector3d::Zero();
    for (const std::uint32_t u : neighbours_.of(v)) sum += mesh_.positions[u];
    return sum / static_cast<double>(neighbours_.of(v).size());
  }

  /// Standard deviation of the noise along the normal. The distance of a vertex from the mean of its neighbours, less
  /// the mean of their own such distances, is free of curvature. Where vertices have six neighbours, its standard
  /// deviation is 1.359 of that of the noise, and its median 0.674 of its standard deviation.
  double noise() const {
    std::vector<Vector3d> normal(mesh_.positions.size(), Vector3d::Zero());
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
      for (const std::uint32_t v : mesh_.triangles[t])
        normal[v] += (mesh_.corner(t, 1) - mesh_.corner(t, 0)).cross(mesh_.corner(t, 2) - mesh_.corner(t, 0));
    std::vector<double> height(normal.size(), 0), roughness;
    for (std::uint32_t v = 0; v < normal.size(); ++v)
      if (normal[v].norm() > 0) height[v] = (mesh_.positions[v] - meanOfNeighbours(v)).dot(normal[v].normalized());
    for (std::uint32_t v = 0; v < normal.size(); ++v) {
      if (!(normal[v].norm() > 0)) continue;
      double sum = 0;
      for (const std::uint32_t u : neighbours_.of(v)) sum += height[u];
      roughness.push_back(std::abs(height[v] - sum / static_cast<double>(neighbours_.of(v).size())));
    }
    if (roughness.empty()) return 0;
    const auto middle = roughness.begin() + static_cast<std::ptrdiff_t>(roughness.size() / 2);
    std::nth_element(roughness.begin(), middle, roughness.end());
    return *middle / (0.674 * 1.359);
  }

  MovedVertices moved() const {
    MovedVertices moved;
    for (std::size_t v = 0; v < origin_.size(); ++v) {
      const double distance = (mesh_.positions[v] - origin_[v]).norm();
      if (!(distance > 0)) continue;
      ++moved.count;
      moved.mean += distance;
      moved.farthest = std::max(moved.farthest, distance);
    }
    if (moved.count > 0) moved.mean /= static_cast<double>(moved.count);
    return moved;
  }

  TriangleMesh& mesh_;
  const std::vector<Vector3d> origin_;
  const VertexNeighbours neighbours_;
  CrossingSearch search_;         // contains the triangles that do not move
  std::vector<Triangle> moving_;  // the others
  std::vector<char> is_movable_;
};

}  // namespace

MovedVertices untangleScan(ScanSurface& surface) { return Untangling(surface).run(); }

}  // namespace spheretree::builder
