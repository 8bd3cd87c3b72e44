// SPDX-License-Identifier: GPL-3.0-or-later
#include "skin/smooth_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include "mesh/mesh_edges.h"
#include "skin/cubic_fit.h"
#include "skin/loop_limit.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

// Largest mean unevenness at which the masks of a subdivision surface are used. It is 0.02 in the median on meshes that
// were subdivided once from an irregular one, and 0.16 after as many of its vertices were chosen at random.
constexpr double kEven = 0.1;
constexpr int kEvenRounds = 2;         // of averaging
constexpr std::size_t kHub = 64;       // triangles at a vertex; its neighbours do not fit each other's, which costs the square of these
constexpr std::size_t kFitPoints = 9;  // the coefficients of a cubic through a vertex; two rings have twice as many vertices

constexpr double kSmoothPassing = 0.5;  // cosine of the angle of a crease at a vertex, above which the vertex is not a corner of the crease

constexpr int kGuardRounds = 8;  // rounds of solving without the vertices where the limit surface folds; three are usual
// Largest angle between a normal of the limit surface and the normals around it, beyond the largest angle between two
// of these [rad].
constexpr double kLean = 0.1;
constexpr double kMaxLean = 0.5;  // cosine of the largest angle between a triangle and the normals of its patch
constexpr std::array<std::array<double, 3>, 7> kNodes{
    {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.5, 0.5, 0}, {0, 0.5, 0.5}, {0.5, 0, 0.5}, {1.0 / 3, 1.0 / 3, 1.0 / 3}}};

Vector3d unitOr(const Vector3d& n, const Vector3d& otherwise) {
  const double length = n.norm();
  return length > 0 ? Vector3d(n / length) : otherwise;
}

Vector3d perpendicularTo(const Vector3d& n, const Vector3d& direction) {
  const double square = direction.squaredNorm();
  return square > 0 ? Vector3d(n - direction * (n.dot(direction) / square)) : n;
}

double angleBetween(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

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

class SurfaceSmoother {
 public:
  SurfaceSmoother(const TriangleMesh& mesh, SurfaceEdges& edges) : mesh_(mesh), edges_(edges) {}

  SmoothSurface run() {
    collectCorners();
    findMethods();
    do place();
    while (sharpenLeaning());
    straightenFolds();
    return std::move(out_);
  }

 private:
  // Finds what each vertex follows: the limit of a subdivision surface, a fit, or neither.
  void findMethods() {
    findRings();
    fitCubics();
    dropUnevenRings();
    findCreases();
    for (int round = 0; round < kGuardRounds; ++round) {
      limit_.emplace(mesh_.positions, rings_, creases_);
      if (!dropFoldedRings()) break;
    }
  }

  void place() {
    out_.corner_normal.resize(mesh_.triangles.size());
    for (std::uint32_t v = 0; v < mesh_.positions.size(); ++v) {
      if (!rings_[v].empty())
        placeNormal(v, limit_->normal(v));
      else if (fits_[v])
        placeNormal(v, fits_[v]->at(at(v)).normal);
      else
        placeSectorNormals(v);
    }
    out_.side_normal.resize(mesh_.triangles.size());
    out_.offset.assign(edges_.kind.size(), Vector3d::Zero());
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
      for (std::uint32_t k = 0; k < 3; ++k) placeMiddle({t, k});
  }

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
    rings_.assign(mesh_.positions.size(), {});
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

  void placeNormal(std::uint32_t v, const Vector3d& n) {
    for (const MeshCorner c : corners_[v]) out_.corner_normal[c.triangle][c.k] = n;
  }

  // The masks of a subdivision surface presume that the neighbours of a vertex lie like a linear image of a regular
  // polygon. How far they do not: the share of their squared distances that no such image explains.
  double unevenness(std::uint32_t v) const {
    const std::vector<std::uint32_t>& ring = rings_[v];
    const auto n = static_cast<double>(ring.size());
    const Vector3d normal = facetNormal(corners_[v]);
    Vector3d u = Vector3d::Zero(), w = Vector3d::Zero();
    double squares = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / n;
      const Vector3d flat = perpendicularTo(at(ring[i]) - at(v), normal);
      u += std::cos(angle) * flat, w += std::sin(angle) * flat;
      squares += flat.squaredNorm();
    }
    return squares > 0 ? 1 - 2 / n * (u.squaredNorm() + w.squaredNorm()) / squares : 1;
  }

  // Averaged over the neighbours, since the limit through all vertices depends on the rings of each.
  std::vector<double> meanUnevenness() const {
    std::vector<double> uneven(rings_.size(), 0);
    for (std::uint32_t v = 0; v < rings_.size(); ++v)
      if (!rings_[v].empty()) uneven[v] = unevenness(v);
    for (int round = 0; round < kEvenRounds; ++round) {
      std::vector<double> mean(uneven);
      for (std::uint32_t v = 0; v < rings_.size(); ++v) {
        double count = 1;
        for (const std::uint32_t w : rings_[v])
          if (!rings_[w].empty()) mean[v] += uneven[w], ++count;
        mean[v] /= count;
      }
      uneven = std::move(mean);
    }
    return uneven;
  }

  // Two estimates of errors decide. The limit turns with the unevenness, and the more the facets differ. Cubics are as
  // far from each other, half way to the neighbours, as from what both stand for.
  void dropUnevenRings() {
    const std::vector<double> uneven = meanUnevenness();
    for (std::uint32_t v = 0; v < rings_.size(); ++v) {
      if (rings_[v].empty()) continue;
      const Vector3d n = facetNormal(corners_[v]);
      double bend = 0;
      for (const Vector3d& facet : facetsAt(v)) bend = std::max(bend, angleBetween(n, facet));
      if (uneven[v] > kEven || disagreement(v) < uneven[v] * bend) rings_[v].clear();
    }
  }

  /// Mean angle between the normals of the cubics at both ends of an edge, in its middle [rad]; infinite without any.
  double disagreement(std::uint32_t v) const {
    double sum = 0, count = 0;
    for (const std::uint32_t w : rings_[v]) {
      if (!fits_[v] || !fits_[w]) continue;
      const Vector3d middle = 0.5 * (at(v) + at(w));
      sum += angleBetween(fits_[v]->at(middle).normal, fits_[w]->at(middle).normal), ++count;
    }
    return count > 0 ? sum / count : std::numeric_limits<double>::infinity();
  }

  // Where triangles are uneven, the limit normal may deviate strongly from the facets, or the surface may fold. Such
  // vertices lose their rings, and the others are solved again without them. Returns true if there were such vertices.
  bool dropFoldedRings() {
    bool any = false;
    for (std::uint32_t v = 0; v < rings_.size(); ++v) {
      if (rings_[v].empty()) continue;
      if (leansWithin(limit_->normal(v), facetsAt(v))) continue;
      rings_[v].clear();
      any = true;
    }
    return any;
  }

  std::vector<Vector3d> facetsAt(std::uint32_t v) const {
    std::vector<Vector3d> facets;
    for (const MeshCorner c : corners_[v]) facets.push_back(edges_.triangle_normal[c.triangle]);
    return facets;
  }

  /// Whether the surface is smooth around a vertex: neither at a crease nor beside a flat face.
  bool isSmoothAt(std::uint32_t v) const {
    return corners_[v].size() > 2 && std::none_of(corners_[v].begin(), corners_[v].end(), [&](const MeshCorner c) {
             return edges_.isSharp(edgeAfter(c)) || edges_.isSharp(edgeBefore(c)) || edges_.flat_face[c.triangle] != kNoIndex;
           });
  }

  void fitCubics() {
    is_smooth_.resize(mesh_.positions.size());
    for (std::uint32_t v = 0; v < is_smooth_.size(); ++v) is_smooth_[v] = isSmoothAt(v) && corners_[v].size() <= kHub;
    fits_.assign(mesh_.positions.size(), std::nullopt);
    found_by_.assign(mesh_.positions.size(), kNoIndex);
    for (std::uint32_t v = 0; v < fits_.size(); ++v) {
      if (!is_smooth_[v]) continue;
      const std::vector<Vector3d> around = pointsAround(v);
      if (around.size() < kFitPoints) continue;
      fits_[v].emplace(at(v), facetNormal(corners_[v]), around);
      if (!leansWithin(fits_[v]->at(at(v)).normal, facetsAt(v))) fits_[v].reset();
    }
  }

  // Two rings of vertices around `v`, without those beyond a crease, a flat face or the hub of a fan.
  std::vector<Vector3d> pointsAround(std::uint32_t v) {
    std::vector<std::uint32_t> found{v};
    found_by_[v] = v;
    std::size_t begin = 0;
    for (int ring = 0; ring < 2; ++ring) {
      const std::size_t end = found.size();
      for (; begin < end; ++begin) {
        if (!is_smooth_[found[begin]]) continue;
        for (const MeshCorner c : corners_[found[begin]])
          for (const std::uint32_t w : {vertexAt(c, 1), vertexAt(c, 2)})
            if (std::exchange(found_by_[w], v) != v) found.push_back(w);
      }
    }
    std::vector<Vector3d> points;
    for (const std::uint32_t w : found)
      if (at(w) != at(v)) points.push_back(at(w));
    return points;
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
      const LoopLimit::Middle middle = middleOf(e, a, b, m, n);
      normal = middle.normal;
      if (s == c.triangle) out_.offset[e] = middle.offset;
    }
  }

  // The middle on the limit surface, if both ends are on it, or between the cubics of both ends. Otherwise, and if that
  // deviates strongly from its surroundings, the middle of the curve whose ends are perpendicular to the normals there.
  LoopLimit::Middle middleOf(std::uint32_t e, std::uint32_t a, std::uint32_t b, const Vector3d& m, const Vector3d& n) const {
    const auto [s, t] = edges_.triangle[e];
    std::optional<LoopLimit::Middle> middle;
    if (!rings_[a].empty() && !rings_[b].empty())
      middle = limit_->middle(a, b);
    else if (fits_[a] && fits_[b])
      middle = fittedMiddle(a, b);
    if (middle && leansWithin(middle->normal, {m, n, edges_.triangle_normal[s], edges_.triangle_normal[t]})) return *middle;
    const Vector3d chord = at(b) - at(a), u = chord - m * m.dot(chord), w = chord - n * n.dot(chord);
    return {(u - w) / 8, unitOr(perpendicularTo(m + n, 1.5 * chord - 0.25 * (u + w)), unitOr(m + n, m))};
  }

  LoopLimit::Middle fittedMiddle(std::uint32_t a, std::uint32_t b) const {
    const Vector3d chord_middle = 0.5 * (at(a) + at(b));
    const CubicFit::Point one = fits_[a]->at(chord_middle), other = fits_[b]->at(chord_middle);
    return {0.5 * (one.position + other.position) - chord_middle, unitOr(one.normal + other.normal, Vector3d::Zero())};
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

  // A triangle from which a normal of its patch deviates far, as at the tip of a needle or in a fold, becomes a facet
  // with sharp sides. (Another normal for this triangle alone would make the felt direction jump at a smooth side.) A
  // facet has its own normal everywhere, so that this ends. Its vertices then have a normal for each sector; all others
  // keep theirs. Returns whether there were any.
  bool sharpenLeaning() {
    bool any = false;
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      const Vector3d& flat = edges_.triangle_normal[t];
      const auto leans = [&](const Vector3d& n) { return n.dot(flat) < kMaxLean; };
      const auto &corner = out_.corner_normal[t], &side = out_.side_normal[t];
      if (flat.isZero(0) || !(std::any_of(corner.begin(), corner.end(), leans) || std::any_of(side.begin(), side.end(), leans))) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        any |= !edges_.isSharp(edges_.edge[t][k]);
        edges_.kind[edges_.edge[t][k]] = EdgeKind::Sharp;
        rings_[mesh_.triangles[t][k]].clear();
        fits_[mesh_.triangles[t][k]].reset();
      }
    }
    return any;
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
  SurfaceEdges& edges_;
  SmoothSurface out_;
  std::vector<std::vector<MeshCorner>> corners_;       // (vertices) in the order of the triangles
  Rings rings_;                                        // (vertices) empty: not on the limit surface
  std::vector<std::array<std::uint32_t, 2>> creases_;  // (vertices)
  std::optional<LoopLimit> limit_;
  std::vector<std::optional<CubicFit>> fits_;  // (vertices)
  std::vector<char> is_smooth_;                // (vertices) neither at a crease or flat face, nor the hub of a fan
  std::vector<std::uint32_t> found_by_;        // (vertices) whose rings a vertex was last found in
};

}  // namespace

SmoothSurface smoothSurface(const TriangleMesh& mesh, SurfaceEdges& edges) { return SurfaceSmoother(mesh, edges).run(); }

}  // namespace spheretree::builder
