// SPDX-License-Identifier: GPL-3.0-or-later
#include "skin/loop_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "mesh/mesh_edges.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

constexpr int kSolverRounds = 60;  // of the solver; the error falls by 4 or more in each of the first, and is far below float after 30

/// Of the control vertex in the limit mask of a vertex with n neighbours, each of which has the weight 1.
double loopWeight(std::size_t n) {
  const double turn = 0.375 + 0.25 * std::cos(2 * std::numbers::pi / static_cast<double>(n));
  const double beta = (0.625 - turn * turn) / static_cast<double>(n);
  return 0.375 / beta;
}

Vector3d unitOr(const Vector3d& n, const Vector3d& otherwise) {
  const double length = n.norm();
  return length > 0 ? Vector3d(n / length) : otherwise;
}

Vector3d perpendicularTo(const Vector3d& n, const Vector3d& direction) {
  const double square = direction.squaredNorm();
  return square > 0 ? Vector3d(n - direction * (n.dot(direction) / square)) : n;
}

/// Direction of the normal from a ring of points, counter-clockwise, by the tangent masks of Loop's surface.
template <class Ring>
Vector3d ringNormal(const Ring& ring) {
  Vector3d u = Vector3d::Zero(), v = Vector3d::Zero();
  const double step = 2 * std::numbers::pi / static_cast<double>(ring.size());
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const double angle = step * static_cast<double>(i);
    u += std::cos(angle) * ring[i], v += std::sin(angle) * ring[i];
  }
  return u.cross(v);
}

struct MeshCorner {
  std::uint32_t triangle, k;
};

class LoopSurface {
 public:
  LoopSurface(const TriangleMesh& mesh, const SurfaceEdges& edges) : mesh_(mesh), edges_(edges) {}

  SmoothSurface run() {
    collectCorners();
    findRings();
    solve();
    out_.corner_normal.resize(mesh_.triangles.size());
    for (std::uint32_t v = 0; v < mesh_.positions.size(); ++v) {
      if (rings_[v].empty())
        placeSectorNormals(v);
      else
        placeLimitNormal(v);
    }
    out_.side_normal.resize(mesh_.triangles.size());
    out_.offset.assign(edges_.kind.size(), Vector3d::Zero());
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
      for (std::uint32_t k = 0; k < 3; ++k) placeMiddle({t, k});
    return std::move(out_);
  }

 private:
  std::uint32_t vertexAt(MeshCorner c, std::uint32_t further = 0) const { return mesh_.triangles[c.triangle][(c.k + further) % 3]; }
  const Vector3d& at(std::uint32_t v) const { return mesh_.positions[v]; }
  std::uint32_t edgeAfter(MeshCorner c) const { return edges_.edge[c.triangle][c.k]; }             // from its vertex on
  std::uint32_t edgeBefore(MeshCorner c) const { return edges_.edge[c.triangle][(c.k + 2) % 3]; }  // that ends in its vertex

  void collectCorners() {
    corners_.resize(mesh_.positions.size());
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
      for (std::uint32_t k = 0; k < 3; ++k) corners_[mesh_.triangles[t][k]].push_back({t, k});
  }

  // Neighbours, counter-clockwise, of each vertex that no sharp edge or flat face fixes and whose triangles make one ring.
  void findRings() {
    rings_.resize(mesh_.positions.size());
    for (std::uint32_t v = 0; v < rings_.size(); ++v) {
      const std::vector<MeshCorner>& corners = corners_[v];
      if (edges_.is_fixed[v] || corners.size() < 3) continue;
      std::vector<std::pair<std::uint32_t, std::uint32_t>> next;
      for (const MeshCorner c : corners) next.emplace_back(vertexAt(c, 1), vertexAt(c, 2));
      std::sort(next.begin(), next.end());
      std::vector<std::uint32_t> ring;
      std::uint32_t here = next[0].first;
      do {
        ring.push_back(here);
        const auto found = std::lower_bound(next.begin(), next.end(), std::pair(here, 0u));
        if (found == next.end() || found->first != here) break;
        here = found->second;
      } while (here != ring[0] && ring.size() < corners.size());
      if (here == ring[0] && ring.size() == corners.size()) rings_[v] = std::move(ring);
    }
  }

  // Control vertices by the iteration of Gauss and Seidel, so that the limit goes through the vertices of the mesh. No control vertex
  // leaves its vertex by more than half of the mean length of its edges: noise is not to swing the surface.
  void solve() {
    control_ = mesh_.positions;
    std::vector<std::uint32_t> free;
    std::vector<double> reach(control_.size());
    for (std::uint32_t v = 0; v < rings_.size(); ++v) {
      if (rings_[v].empty()) continue;
      free.push_back(v);
      for (const std::uint32_t w : rings_[v]) reach[v] += (at(w) - at(v)).norm() / (2 * static_cast<double>(rings_[v].size()));
    }
    for (int round = 0; round < kSolverRounds; ++round) {
      for (const std::uint32_t v : free) {
        const auto n = static_cast<double>(rings_[v].size());
        const double weight = loopWeight(rings_[v].size());
        Vector3d sum = Vector3d::Zero();
        for (const std::uint32_t w : rings_[v]) sum += control_[w];
        Vector3d moved = ((weight + n) * at(v) - sum) / weight - at(v);
        if (const double length = moved.norm(); length > reach[v]) moved *= reach[v] / length;
        control_[v] = at(v) + moved;
      }
    }
  }

  void placeLimitNormal(std::uint32_t v) {
    std::vector<Vector3d> ring;
    for (const std::uint32_t w : rings_[v]) ring.push_back(control_[w]);
    const Vector3d n = unitOr(ringNormal(ring), facetNormal(corners_[v]));
    for (const MeshCorner c : corners_[v]) out_.corner_normal[c.triangle][c.k] = n;
  }

  /// By the weights of Max: exact where the vertices lie on a sphere, and the same whichever way a rectangle is split.
  Vector3d facetNormal(const std::vector<MeshCorner>& corners) const {
    Vector3d sum = Vector3d::Zero();
    for (const MeshCorner c : corners) {
      const Vector3d a = at(vertexAt(c, 1)) - at(vertexAt(c)), b = at(vertexAt(c, 2)) - at(vertexAt(c));
      const double squares = a.squaredNorm() * b.squaredNorm();
      if (squares > 0) sum += a.cross(b) / squares;
    }
    return unitOr(sum, unitOr(edges_.triangle_normal[corners[0].triangle], Vector3d::UnitZ()));
  }

  // Vertices that a sharp edge or a flat face fixes have a normal for each sector between sharp edges.
  void placeSectorNormals(std::uint32_t v) {
    const std::vector<MeshCorner>& corners = corners_[v];
    if (corners.empty()) return;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> sides;  // edge, place of the corner
    for (std::uint32_t i = 0; i < corners.size(); ++i)
      for (const std::uint32_t e : {edgeAfter(corners[i]), edgeBefore(corners[i])})
        if (!edges_.isSharp(e)) sides.emplace_back(e, i);
    std::sort(sides.begin(), sides.end());
    Groups sectors(corners.size());
    for (std::size_t i = 1; i < sides.size(); ++i)
      if (sides[i].first == sides[i - 1].first) sectors.join(sides[i].second, sides[i - 1].second);
    std::vector<std::vector<MeshCorner>> sector(corners.size());
    for (std::uint32_t i = 0; i < corners.size(); ++i) sector[sectors.root(i)].push_back(corners[i]);
    for (const std::vector<MeshCorner>& one : sector)
      if (!one.empty()) placeSectorNormal(v, one);
  }

  // The normal of the flat face in the sector; where there are several, each keeps its own.
  void placeSectorNormal(std::uint32_t v, const std::vector<MeshCorner>& sector) {
    std::vector<std::uint32_t> faces;
    for (const MeshCorner c : sector)
      if (const std::uint32_t f = edges_.flat_face[c.triangle]; f != kNoIndex) faces.push_back(f);
    std::sort(faces.begin(), faces.end());
    faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
    Vector3d sum = Vector3d::Zero();
    for (const std::uint32_t f : faces) sum += edges_.face_normal[f];
    const Vector3d shared = faces.empty()       ? unitOr(acrossCrease(v, sector, facetNormal(sector)), facetNormal(sector))
                            : faces.size() == 1 ? edges_.face_normal[faces[0]]
                                                : unitOr(sum, edges_.face_normal[faces[0]]);
    for (const MeshCorner c : sector) {
      const std::uint32_t f = edges_.flat_face[c.triangle];
      out_.corner_normal[c.triangle][c.k] = f == kNoIndex ? shared : edges_.face_normal[f];
    }
  }

  // Where a crease passes smoothly, the normal is made perpendicular to it: to the parabola through the vertex and the crease's next ones.
  Vector3d acrossCrease(std::uint32_t v, const std::vector<MeshCorner>& sector, const Vector3d& n) const {
    std::vector<Vector3d> ends;
    for (const MeshCorner c : sector) {
      if (edges_.isSharp(edgeAfter(c))) ends.emplace_back(at(vertexAt(c, 1)) - at(v));
      if (edges_.isSharp(edgeBefore(c))) ends.emplace_back(at(v) - at(vertexAt(c, 2)));
    }
    if (ends.size() != 2) return n;
    const double p = ends[0].norm(), q = ends[1].norm();
    if (!(p > 0 && q > 0) || ends[0].dot(ends[1]) < 0.5 * p * q) return n;  // a corner of the crease
    return perpendicularTo(n, ends[0] * (q / p) + ends[1] * (p / q));
  }

  void placeMiddle(MeshCorner c) {
    const std::uint32_t e = edgeAfter(c), a = vertexAt(c), b = vertexAt(c, 1);
    const Vector3d &m = out_.corner_normal[c.triangle][c.k], &n = out_.corner_normal[c.triangle][(c.k + 1) % 3];
    const Vector3d chord = at(b) - at(a);
    Vector3d& normal = out_.side_normal[c.triangle][c.k];
    const bool is_first = edges_.triangle[e][0] == c.triangle;
    if (const std::uint32_t f = faceBeside(c); f != kNoIndex) {
      normal = edges_.face_normal[f];
    } else if (edges_.kind[e] == EdgeKind::Smooth && !rings_[a].empty() && !rings_[b].empty()) {
      if (is_first)
        normal = limitMiddle(e, a, b);
      else
        normal = out_.side_normal[edges_.triangle[e][0]][sideOf(edges_.triangle[e][0], e)];
    } else if (edges_.kind[e] == EdgeKind::Smooth) {
      // The cubic curve whose ends are perpendicular to the normals there.
      const Vector3d u = chord - m * m.dot(chord), w = chord - n * n.dot(chord);
      if (is_first) out_.offset[e] = (u - w) / 8;
      normal = unitOr(perpendicularTo(m + n, 1.5 * chord - 0.25 * (u + w)), unitOr(m + n, m));
    } else {
      normal = unitOr(perpendicularTo(m + n, chord), unitOr(m + n, m));
    }
  }

  // The flat face of the triangle at a side, or of that across a side that is not sharp.
  std::uint32_t faceBeside(MeshCorner c) const {
    const std::uint32_t e = edgeAfter(c), own = edges_.flat_face[c.triangle];
    if (own != kNoIndex || edges_.isSharp(e)) return own;
    const auto [s, t] = edges_.triangle[e];
    return edges_.flat_face[s == c.triangle ? t : s];
  }

  std::uint32_t sideOf(std::uint32_t t, std::uint32_t e) const {
    return static_cast<std::uint32_t>(std::find(edges_.edge[t].begin(), edges_.edge[t].end(), e) - edges_.edge[t].begin());
  }

  // After one step of subdivision the middle is a vertex with six neighbours: its place and its normal are those of the limit there.
  Vector3d limitMiddle(std::uint32_t e, std::uint32_t a, std::uint32_t b) {
    const std::vector<std::uint32_t>&ra = rings_[a], &rb = rings_[b];
    const auto placeOf = [](const std::vector<std::uint32_t>& ring, std::uint32_t v) {
      return static_cast<std::size_t>(std::find(ring.begin(), ring.end(), v) - ring.begin());
    };
    const std::size_t n = ra.size(), m = rb.size(), i = placeOf(ra, b), j = placeOf(rb, a);
    const auto p = [&](std::uint32_t v) -> const Vector3d& { return control_[v]; };
    const std::uint32_t left = ra[(i + 1) % n], right = ra[(i + n - 1) % n];
    const auto edgePoint = [&](std::uint32_t from, std::uint32_t to, std::uint32_t s, std::uint32_t t) {
      return Vector3d(0.375 * (p(from) + p(to)) + 0.125 * (p(s) + p(t)));
    };
    const std::array<Vector3d, 6> ring{moved(b), edgePoint(b, left, a, rb[(j + m - 2) % m]),  edgePoint(a, left, b, ra[(i + 2) % n]),
                                       moved(a), edgePoint(a, right, b, ra[(i + n - 2) % n]), edgePoint(b, right, a, rb[(j + 2) % m])};
    Vector3d sum = 6 * edgePoint(a, b, left, right);
    for (const Vector3d& q : ring) sum += q;
    out_.offset[e] = sum / 12 - 0.5 * (at(a) + at(b));
    return unitOr(ringNormal(ring), unitOr(edges_.triangle_normal[edges_.triangle[e][0]], Vector3d::UnitZ()));
  }

  /// Where one step of subdivision takes a control vertex.
  Vector3d moved(std::uint32_t v) const {
    const auto n = static_cast<double>(rings_[v].size());
    const double beta = 0.375 / loopWeight(rings_[v].size());
    Vector3d sum = Vector3d::Zero();
    for (const std::uint32_t w : rings_[v]) sum += control_[w];
    return (1 - n * beta) * control_[v] + beta * sum;
  }

  const TriangleMesh& mesh_;
  const SurfaceEdges& edges_;
  SmoothSurface out_;
  std::vector<std::vector<MeshCorner>> corners_;   // (vertices) in the order of the triangles
  std::vector<std::vector<std::uint32_t>> rings_;  // (vertices) empty: fixed
  std::vector<Vector3d> control_;                  // (vertices)
};

}  // namespace

SmoothSurface loopSurface(const TriangleMesh& mesh, const SurfaceEdges& edges) { return LoopSurface(mesh, edges).run(); }

}  // namespace spheretree::builder
