// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/cut_labels.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "split/border_distances.h"

namespace spheretree::builder {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double kMargin = 0.15;  // share of an edge between a cut and the ends of the edge, which avoids slivers

double valueOf(const std::vector<RegionDistance>& known, std::int32_t region, double otherwise) {
  for (const RegionDistance& k : known)
    if (k.region == region) return k.distance;
  return otherwise;
}

class Cutter {
 public:
  Cutter(ScanSurface& surface, double smooth)
      : s_(surface), mesh_(surface.mesh), smooth_(smooth), before_(surface.vertex_region), neighbours_(surface.mesh) {
    findNormals();
  }

  void run() {
    if (smooth_ > 0) {
      BorderDistances found = findBorderDistances(s_, neighbours_, smooth_);
      band_ = found.band;
      known_ = std::move(found.of_vertex);
      fixed_ = known_;
      for (int round = 0; round < kSmoothingRounds; ++round) smoothDistances();
      assign();
    }
    cut();
  }

 private:
  void findNormals() {
    normal_.assign(mesh_.positions.size(), Vector3d::Zero());
    for (const Triangle& t : mesh_.triangles) {
      const Vector3d n = (mesh_.positions[t[1]] - mesh_.positions[t[0]]).cross(mesh_.positions[t[2]] - mesh_.positions[t[0]]);
      for (const std::uint32_t v : t) normal_[v] += n;
    }
  }

  /// Value at `v` of the linear function on the tangent plane that fits the values at `v` and its neighbours best.
  double fitted(std::uint32_t v, std::int32_t region) const {
    const Vector3d& p = mesh_.positions[v];
    const Vector3d n = normal_[v].normalized();
    int smallest = 0;
    n.cwiseAbs().minCoeff(&smallest);
    const Vector3d u = n.cross(Vector3d::Unit(smallest)).normalized(), w = n.cross(u);
    Eigen::Matrix3d sums = Eigen::Matrix3d::Zero();
    Vector3d right = Vector3d::Zero();
    const auto add = [&](const Vector3d& q, double value) {
      const Vector3d row(1, (q - p).dot(u), (q - p).dot(w));
      sums += row * row.transpose();
      right += value * row;
    };
    const double own = valueOf(known_[v], region, 0);
    add(p, own), add(p, own);  // twice, because each neighbour is visited twice
    bool is_whole = true;
    for (const std::uint32_t q : neighbours_.of(v)) {
      const double far = before_[q] == region ? band_ : -band_, value = valueOf(known_[q], region, far);
      is_whole = is_whole && value != far;
      add(mesh_.positions[q], value);
    }
    if (!is_whole) return own;  // values at the end of the band are not smoothed
    const Eigen::LDLT<Eigen::Matrix3d> solver(sums);
    const double value = solver.solve(right)[0];
    return std::isfinite(value) && std::abs(value) < band_ ? value : own;
  }

  void smoothDistances() {
    std::vector<std::vector<RegionDistance>> next = known_;
    for (std::uint32_t v = 0; v < known_.size(); ++v)
      for (std::size_t k = 0; k < known_[v].size(); ++k) {
        const double origin = fixed_[v][k].distance;
        next[v][k].distance = std::clamp(fitted(v, known_[v][k].region), origin - smooth_, origin + smooth_);
      }
    known_ = std::move(next);
  }

  void assign() {
    for (std::size_t v = 0; v < known_.size(); ++v) {
      double best = valueOf(known_[v], before_[v], band_);
      for (const RegionDistance& k : known_[v])
        if (k.distance > best) {
          best = k.distance;
          s_.vertex_region[v] = k.region;
        }
    }
    dropStrays();
  }

  /// Restores the old region of changed vertices that are not connected to a vertex which already had their new region.
  void dropStrays() {
    std::vector<char> holds(before_.size(), 0);
    std::vector<std::uint32_t> stack;
    for (std::uint32_t v = 0; v < before_.size(); ++v)
      if (s_.vertex_region[v] == before_[v]) holds[v] = 1, stack.push_back(v);
    while (!stack.empty()) {
      const std::uint32_t v = stack.back();
      stack.pop_back();
      for (const std::uint32_t u : neighbours_.of(v)) {
        if (holds[u] || s_.vertex_region[u] != s_.vertex_region[v]) continue;
        holds[u] = 1;
        stack.push_back(u);
      }
    }
    for (std::uint32_t v = 0; v < before_.size(); ++v)
      if (!holds[v]) s_.vertex_region[v] = before_[v];
  }

  /// Position on the edge from `u` to `v`, as a share, at which the values of both regions are equal.
  double cutAt(std::uint32_t u, std::uint32_t v) const {
    if (!(smooth_ > 0)) return 0.5;
    const std::int32_t a = s_.vertex_region[u], b = s_.vertex_region[v];
    const double at_u = valueOf(known_[u], a, band_) - valueOf(known_[u], b, -band_);
    const double at_v = valueOf(known_[v], b, band_) - valueOf(known_[v], a, -band_);
    const double sum = at_u + at_v;
    return at_u >= 0 && at_v >= 0 && sum > 0 ? std::clamp(at_u / sum, kMargin, 1 - kMargin) : 0.5;
  }

  void cut() {
    const EdgeFaces faces(mesh_);
    const std::size_t old_triangles = mesh_.triangles.size();
    std::vector<std::array<std::uint32_t, 3>> cut_of(old_triangles, {kNone, kNone, kNone});
    for (std::uint32_t t = 0; t < old_triangles; ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t u = mesh_.triangles[t][k], v = mesh_.triangles[t][(k + 1) % 3];
        if (s_.vertex_region[u] == s_.vertex_region[v] || cut_of[t][k] != kNone) continue;
        // From the lower vertex, so that both triangles compute the same point.
        const std::uint32_t low = std::min(u, v), high = std::max(u, v);
        const double share = cutAt(low, high);
        cut_of[t][k] = add((1 - share) * mesh_.positions[low] + share * mesh_.positions[high]);
        if (const std::uint32_t other = faces.face(v, u); other != kNone)
          for (std::size_t j = 0; j < 3; ++j)
            if (mesh_.triangles[other][j] == v) cut_of[other][j] = cut_of[t][k];
      }
    s_.region.assign(old_triangles, kGumRegion);
    for (std::uint32_t t = 0; t < old_triangles; ++t) cutTriangle(t, cut_of[t]);
  }

  std::uint32_t add(const Vector3d& p) {
    mesh_.positions.push_back(p);
    return static_cast<std::uint32_t>(mesh_.positions.size() - 1);
  }

  /// The first piece replaces the triangle; the others are appended.
  void put(std::uint32_t t, bool is_first, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::int32_t region) {
    if (is_first) {
      mesh_.triangles[t] = {a, b, c};
      s_.region[t] = region;
      return;
    }
    mesh_.triangles.push_back({a, b, c});
    s_.region.push_back(region);
    s_.is_invented.push_back(s_.is_invented[t]);
  }

  void cutTriangle(std::uint32_t t, const std::array<std::uint32_t, 3>& cuts) {
    const Triangle old = mesh_.triangles[t];
    const auto region = [&](std::size_t k) { return s_.vertex_region[old[k]]; };
    const auto isCut = [&](std::size_t k) { return cuts[k] != kNone; };
    if (!isCut(0) && !isCut(1) && !isCut(2)) {
      s_.region[t] = region(0);
      return;
    }
    if (isCut(0) && isCut(1) && isCut(2)) {
      const std::uint32_t middle = add((mesh_.positions[cuts[0]] + mesh_.positions[cuts[1]] + mesh_.positions[cuts[2]]) / 3);
      for (std::size_t k = 0; k < 3; ++k) {
        put(t, k == 0, old[k], cuts[k], middle, region(k));
        put(t, false, old[k], middle, cuts[(k + 2) % 3], region(k));
      }
      return;
    }
    std::size_t k = 0;  // the corner with a region of its own
    while (!(isCut(k) && isCut((k + 2) % 3))) ++k;
    const std::uint32_t p = cuts[k], q = cuts[(k + 2) % 3], b = old[(k + 1) % 3], c = old[(k + 2) % 3];
    put(t, true, old[k], p, q, region(k));
    const double along = (mesh_.positions[p] - mesh_.positions[c]).squaredNorm(),
                 across = (mesh_.positions[b] - mesh_.positions[q]).squaredNorm();
    if (along < across) {
      put(t, false, p, b, c, region((k + 1) % 3));
      put(t, false, p, c, q, region((k + 1) % 3));
    } else {
      put(t, false, p, b, q, region((k + 1) % 3));
      put(t, false, b, c, q, region((k + 1) % 3));
    }
  }

  ScanSurface& s_;
  TriangleMesh& mesh_;
  double smooth_, band_ = 0;
  std::vector<std::int32_t> before_;  // original regions of the vertices
  const VertexNeighbours neighbours_;
  std::vector<Vector3d> normal_;
  std::vector<std::vector<RegionDistance>> known_, fixed_;  // after and before the smoothing
};

}  // namespace

void cutLabels(ScanSurface& surface, double smooth) { Cutter(surface, smooth).run(); }

}  // namespace spheretree::builder
