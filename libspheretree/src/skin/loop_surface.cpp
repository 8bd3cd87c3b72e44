// SPDX-License-Identifier: GPL-3.0-or-later
#include "skin/loop_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "mesh/mesh_edges.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

constexpr int kSolverRounds =
    60;  // iterations of the solver; the error falls by a factor of 4 or more in each of the first ones, and is far below float after 30

constexpr double kSmoothPassing = 0.5;  // cosine of the angle of a crease at a vertex, above which the vertex is not a corner of the crease

constexpr int kGuardRounds = 8;  // rounds of solving without the vertices where the limit surface folds; three are usual
// Largest angle between a normal of the limit surface and the normals around it, beyond the largest angle between two
// of these [rad].
constexpr double kLean = 0.1;
constexpr double kMaxLean = 0.5;  // cosine of the largest angle between a triangle and the normals of its patch
constexpr std::array<std::array<double, 3>, 7> kNodes{
    {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.5, 0.5, 0}, {0, 0.5, 0.5}, {0.5, 0, 0.5}, {1.0 / 3, 1.0 / 3, 1.0 / 3}}};

/// Weight of the control vertex in the limit mask of a vertex with n neighbours, each of which has the weight 1.
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

/// Whether the angle between `n` and each vector of `about` is at most the largest angle between two of these, plus
/// kLean. Unit vectors.
bool leansWithin(const Vector3d& n, const std::vector<Vector3d>& about) {
  double smallest = 1, between = 1;  // cosines
  for (std::size_t i = 0; i < about.size(); ++i) {
    smallest = std::min(smallest, n.dot(about[i]));
    for (std::size_t j = 0; j < i; ++j) between = std::min(between, about[i].dot(about[j]));
  }
  return smallest >= std::cos(std::min(std::acos(std::clamp(between, -1.0, 1.0)) + kLean, 0.5 * std::numbers::pi));
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
    findCreases();
    for (int round = 0; round < kGuardRounds; ++round) {
      solve();
      if (!dropFoldedRings()) break;
    }
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
    rightNormals();
    straightenFolds();
    return std::move(out_);
  }

 private:
  std::uint32_t vertexAt(MeshCorner c, std::uint32_t further = 0) const { return mesh_.triangles[c.triangle][(c.k + further) % 3]; }
  const Vector3d& at(std::uint32_t v) const { return mesh_.positions[v]; }
  std::uint32_t edgeAfter(MeshCorner c) const { return edges_.edge[c.triangle][c.k]; }  // the edge that starts at the corner's vertex
  std::uint32_t edgeBefore(MeshCorner c) const {
    return edges_.edge[c.triangle][(c.k + 2) % 3];
  }  // the edge that ends at the corner's vertex

  void collectCorners() {
    corners_.resize(mesh_.positions.size());
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
      for (std::uint32_t k = 0; k < 3; ++k) corners_[mesh_.triangles[t][k]].push_back({t, k});
  }

  // Finds the neighbours, counter-clockwise, of each vertex that no sharp edge or flat face fixes and whose triangles
  // form one ring.
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

  // Finds the two neighbours along the crease of each vertex that a crease passes smoothly; the same vertex twice:
  // none.
  void findCreases() {
    creases_.assign(mesh_.positions.size(), {0, 0});
    std::vector<std::vector<std::uint32_t>> next(mesh_.positions.size());
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t e = edges_.edge[t][k], a = mesh_.triangles[t][k], b = mesh_.triangles[t][(k + 1) % 3];
        if (!edges_.isSharp(e) || edges_.triangle[e][0] != t) continue;
        next[a].push_back(b), next[b].push_back(a);
      }
    for (std::uint32_t v = 0; v < next.size(); ++v)
      if (next[v].size() == 2 && passesSmoothly(at(v) - at(next[v][0]), at(next[v][1]) - at(v))) creases_[v] = {next[v][0], next[v][1]};
  }

  static bool passesSmoothly(const Vector3d& in, const Vector3d& out) { return in.dot(out) > kSmoothPassing * in.norm() * out.norm(); }

  // Computes control vertices by Gauss-Seidel iteration such that the limit surface passes through the vertices of the
  // mesh, with the mask of a vertex with a ring or of a crease. No control vertex moves from its vertex by more than
  // half of the mean length of the edges in its mask, so that noise does not make the surface oscillate.
  void solve() {
    struct Row {
      std::uint32_t vertex;
      double weight, reach;
      std::vector<std::uint32_t> next;
    };
    std::vector<Row> rows;
    control_ = mesh_.positions;
    for (std::uint32_t v = 0; v < rings_.size(); ++v) {
      const auto& [p, q] = creases_[v];
      Row row{v, 4, 0, {}};
      if (!rings_[v].empty())
        row.next = rings_[v], row.weight = loopWeight(rings_[v].size());
      else if (p != q)
        row.next = {p, q};
      else
        continue;
      for (const std::uint32_t w : row.next) row.reach += (at(w) - at(v)).norm() / (2 * static_cast<double>(row.next.size()));
      rows.push_back(std::move(row));
    }
    for (int round = 0; round < kSolverRounds; ++round) {
      for (const Row& row : rows) {
        const auto n = static_cast<double>(row.next.size());
        Vector3d sum = Vector3d::Zero();
        for (const std::uint32_t w : row.next) sum += control_[w];
        Vector3d moved = ((row.weight + n) * at(row.vertex) - sum) / row.weight - at(row.vertex);
        if (const double length = moved.norm(); length > row.reach) moved *= row.reach / length;
        control_[row.vertex] = at(row.vertex) + moved;
      }
    }
  }

  Vector3d limitNormal(std::uint32_t v) const {
    std::vector<Vector3d> ring;
    for (const std::uint32_t w : rings_[v]) ring.push_back(control_[w]);
    return unitOr(ringNormal(ring), Vector3d::Zero());
  }

  void placeLimitNormal(std::uint32_t v) {
    const Vector3d n = limitNormal(v);
    for (const MeshCorner c : corners_[v]) out_.corner_normal[c.triangle][c.k] = n;
  }

  // Where triangles are uneven, the limit normal may deviate strongly from the facets, or the surface may fold. Such
  // vertices get their normals from the facets, and the others are solved again without them. Returns true if there
  // were such vertices or, after the last round, if there may be; then no vertex is left.
  bool dropFoldedRings() {
    bool any = false;
    for (std::uint32_t v = 0; v < rings_.size(); ++v) {
      if (rings_[v].empty()) continue;
      std::vector<Vector3d> facets;
      for (const MeshCorner c : corners_[v]) facets.push_back(edges_.triangle_normal[c.triangle]);
      if (leansWithin(limitNormal(v), facets)) continue;
      rings_[v].clear();
      any = true;
    }
    return any;
  }

  /// By the weights of Max: exact if the vertices lie on a sphere, and independent of how a rectangle is split.
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
    std::vector<std::pair<std::uint32_t, std::uint32_t>> sides;  // edge, index of the corner
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

  // The normal of the flat face in the sector; if there are several flat faces, each keeps its own normal.
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

  // Where a crease passes smoothly, the normal is made perpendicular to it: to the parabola through the vertex and its
  // two neighbours on the crease.
  Vector3d acrossCrease(std::uint32_t v, const std::vector<MeshCorner>& sector, const Vector3d& n) const {
    std::vector<Vector3d> ends;
    for (const MeshCorner c : sector) {
      if (edges_.isSharp(edgeAfter(c))) ends.emplace_back(at(vertexAt(c, 1)) - at(v));
      if (edges_.isSharp(edgeBefore(c))) ends.emplace_back(at(v) - at(vertexAt(c, 2)));
    }
    if (ends.size() != 2) return n;
    const double p = ends[0].norm(), q = ends[1].norm();
    if (!passesSmoothly(ends[0], ends[1])) return n;  // a corner of the crease
    return perpendicularTo(n, ends[0] * (q / p) + ends[1] * (p / q));
  }

  void placeMiddle(MeshCorner c) {
    const std::uint32_t e = edgeAfter(c), a = vertexAt(c), b = vertexAt(c, 1);
    const Vector3d &m = out_.corner_normal[c.triangle][c.k], &n = out_.corner_normal[c.triangle][(c.k + 1) % 3];
    Vector3d& normal = out_.side_normal[c.triangle][c.k];
    if (const std::uint32_t f = faceBeside(c); f != kNoIndex) {
      normal = edges_.face_normal[f];
    } else if (edges_.kind[e] != EdgeKind::Smooth) {
      normal = unitOr(perpendicularTo(m + n, at(b) - at(a)), unitOr(m + n, m));
    } else if (const auto [s, t] = edges_.triangle[e];
               s != c.triangle && out_.corner_normal[s][(sideOf(s, e) + 1) % 3] == m && out_.corner_normal[s][sideOf(s, e)] == n) {
      normal = out_.side_normal[s][sideOf(s, e)];
    } else {
      const Middle middle = middleOf(e, a, b, m, n);
      normal = middle.normal;
      if (s == c.triangle) out_.offset[e] = middle.offset;
    }
  }

  struct Middle {
    Vector3d offset, normal;
  };

  // The middle on the limit surface, if both ends are on it. Otherwise, and if that deviates strongly from its
  // surroundings, the middle of the cubic curve whose ends are perpendicular to the normals there.
  Middle middleOf(std::uint32_t e, std::uint32_t a, std::uint32_t b, const Vector3d& m, const Vector3d& n) const {
    if (!rings_[a].empty() && !rings_[b].empty()) {
      const Middle middle = limitMiddle(a, b);
      const auto [s, t] = edges_.triangle[e];
      if (leansWithin(middle.normal, {m, n, edges_.triangle_normal[s], edges_.triangle_normal[t]})) return middle;
    }
    const Vector3d chord = at(b) - at(a), u = chord - m * m.dot(chord), w = chord - n * n.dot(chord);
    return {(u - w) / 8, unitOr(perpendicularTo(m + n, 1.5 * chord - 0.25 * (u + w)), unitOr(m + n, m))};
  }

  // The flat face of the triangle at a side, or the one across a side that is not sharp.
  std::uint32_t faceBeside(MeshCorner c) const {
    const std::uint32_t e = edgeAfter(c), own = edges_.flat_face[c.triangle];
    if (own != kNoIndex || edges_.isSharp(e)) return own;
    const auto [s, t] = edges_.triangle[e];
    return edges_.flat_face[s == c.triangle ? t : s];
  }

  std::uint32_t sideOf(std::uint32_t t, std::uint32_t e) const {
    return static_cast<std::uint32_t>(std::find(edges_.edge[t].begin(), edges_.edge[t].end(), e) - edges_.edge[t].begin());
  }

  // After one step of subdivision the middle is a vertex with six neighbours: its position and normal are those of the
  // limit there.
  Middle limitMiddle(std::uint32_t a, std::uint32_t b) const {
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
    return {sum / 12 - 0.5 * (at(a) + at(b)), unitOr(ringNormal(ring), Vector3d::Zero())};
  }

  /// The position of a control vertex after one step of subdivision.
  Vector3d moved(std::uint32_t v) const {
    const auto n = static_cast<double>(rings_[v].size());
    const double beta = 0.375 / loopWeight(rings_[v].size());
    Vector3d sum = Vector3d::Zero();
    for (const std::uint32_t w : rings_[v]) sum += control_[w];
    return (1 - n * beta) * control_[v] + beta * sum;
  }

  // A corner or side whose normal deviates far from that of its triangle, as at the tip of a needle, gets the
  // triangle's own normal.
  void rightNormals() {
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      const Vector3d& flat = edges_.triangle_normal[t];
      if (flat.isZero(0)) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        if (out_.corner_normal[t][k].dot(flat) < kMaxLean) out_.corner_normal[t][k] = flat;
        if (out_.side_normal[t][k].dot(flat) < kMaxLean) out_.side_normal[t][k] = flat;
      }
    }
  }

  // A patch that folds gets straight sides and becomes its flat triangle. Since this changes its neighbours, these are
  // tested again.
  void straightenFolds() {
    std::vector<std::uint32_t> open(mesh_.triangles.size());
    std::iota(open.begin(), open.end(), 0u);
    while (!open.empty()) {
      const std::uint32_t t = open.back();
      open.pop_back();
      if (!folds(t)) continue;
      for (const std::uint32_t e : edges_.edge[t]) {
        if (out_.offset[e].isZero(0)) continue;
        out_.offset[e].setZero();
        for (const std::uint32_t beside : edges_.triangle[e])
          if (beside != kNoIndex && beside != t) open.push_back(beside);
      }
    }
  }

  // Whether the patch faces away from its normals or from its flat triangle, at a node or in its middle.
  bool folds(std::uint32_t t) const {
    const Vector3d &a = mesh_.corner(t, 0), &b = mesh_.corner(t, 1), &c = mesh_.corner(t, 2);
    const std::array<Vector3d, 3> offset{out_.offset[edges_.edge[t][0]], out_.offset[edges_.edge[t][1]], out_.offset[edges_.edge[t][2]]};
    if (offset[0].isZero(0) && offset[1].isZero(0) && offset[2].isZero(0)) return false;
    const Vector3d& flat = edges_.triangle_normal[t];
    const auto& corner = out_.corner_normal[t];
    const auto& side = out_.side_normal[t];
    const std::array<Vector3d, 7> normal{corner[0], corner[1], corner[2], side[0], side[1], side[2], side[0] + side[1] + side[2]};
    for (std::size_t i = 0; i < normal.size(); ++i) {
      const double x = kNodes[i][0], y = kNodes[i][1], z = kNodes[i][2];
      // position = x a + y b + z c + 4 (x y offset_0 + y z offset_1 + z x offset_2); derivatives along b - a and c - a
      const Vector3d u = b - a + 4 * ((x - y) * offset[0] + z * offset[1] - z * offset[2]);
      const Vector3d v = c - a + 4 * (-y * offset[0] + y * offset[1] + (x - z) * offset[2]);
      const Vector3d n = u.cross(v);
      if (!(n.dot(normal[i]) > 0 && n.dot(flat) > 0)) return true;
    }
    return false;
  }

  const TriangleMesh& mesh_;
  const SurfaceEdges& edges_;
  SmoothSurface out_;
  std::vector<std::vector<MeshCorner>> corners_;       // (vertices) in the order of the triangles
  std::vector<std::vector<std::uint32_t>> rings_;      // (vertices) empty: fixed
  std::vector<std::array<std::uint32_t, 2>> creases_;  // (vertices)
  std::vector<Vector3d> control_;                      // (vertices)
};

}  // namespace

SmoothSurface loopSurface(const TriangleMesh& mesh, const SurfaceEdges& edges) { return LoopSurface(mesh, edges).run(); }

}  // namespace spheretree::builder
