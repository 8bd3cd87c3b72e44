// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/distance_field.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "base/ball.h"
#include "base/sum_in_order.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

// For each vertex, the first one in sort order at the same position: corners at equal positions, and edges between
// them, belong together, whatever their indices.
std::vector<std::uint32_t> firstOfEqualPositions(const std::vector<Vector3d>& positions) {
  std::vector<std::uint32_t> by_position(positions.size());
  std::iota(by_position.begin(), by_position.end(), 0u);
  const auto key = [&](std::uint32_t v) { return std::array<double, 3>{positions[v].x(), positions[v].y(), positions[v].z()}; };
  // Equal positions in the order of their indices, so that the result is the same for any number of threads.
  const auto before = [&](std::uint32_t a, std::uint32_t b) { return std::pair(key(a), a) < std::pair(key(b), b); };
  if (!std::is_sorted(by_position.begin(), by_position.end(), before)) tbb::parallel_sort(by_position.begin(), by_position.end(), before);
  std::vector<std::uint32_t> first(positions.size());
  for (std::size_t i = 0; i < by_position.size(); ++i)
    first[by_position[i]] = i > 0 && key(by_position[i]) == key(by_position[i - 1]) ? first[by_position[i - 1]] : by_position[i];
  return first;
}

}  // namespace

NearestPoint nearestOnTriangle(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  // Voronoi regions of the triangle's features (C. Ericson. Real-time collision detection, 2005, section 5.1.5).
  NearestPoint out;
  const auto finish = [&](const Vector3d& q, int feature) {
    out.point = q;
    out.distance = (p - q).norm();
    out.feature = static_cast<std::uint8_t>(feature);
    return out;
  };
  const Vector3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return finish(a, 4);
  const Vector3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return finish(b, 5);
  const Vector3d cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return finish(c, 6);
  // The tests below compare areas, and in a thin triangle their signs are only rounding errors (distances were wrong by
  // 1 % of its length).
  const Vector3d normal = ab.cross(ac);
  const double normal2 = normal.squaredNorm(), sides2 = ab.squaredNorm() * ac.squaredNorm();
  if (!(normal2 > 1e-8 * sides2)) {
    const std::array<Vector3d, 3> corner{a, b, c};
    bool within = normal2 > 1e-15 * sides2;
    for (std::size_t k = 0; k < 3; ++k) {  // side opposite corner k
      const Vector3d &u = corner[(k + 1) % 3], side = corner[(k + 2) % 3] - u;
      const double length2 = side.squaredNorm(), t = length2 > 0 ? std::clamp((p - u).dot(side) / length2, 0.0, 1.0) : 0.0;
      const Vector3d q = u + t * side;
      if ((p - q).norm() < out.distance) finish(q, 1 + static_cast<int>(k));
      within = within && normal.dot(side.cross(p - u)) >= 0;
    }
    if (!within) return out;
    const Vector3d foot = p - (normal.dot(ap) / normal2) * normal;
    return (p - foot).norm() < out.distance ? finish(foot, 0) : out;
  }
  // Uses the normal instead of the products of d1 to d6, which lose twice as many digits for a small triangle far away.
  const double vc = normal.dot(ab.cross(ap));
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return finish(a + (d1 / (d1 - d3)) * ab, 3);
  const double vb = normal.dot(ap.cross(ac));
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return finish(a + (d2 / (d2 - d6)) * ac, 2);
  const double va = normal.dot((c - b).cross(bp));
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return finish(b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b), 1);
  return finish(a + (vb / normal2) * ab + (vc / normal2) * ac, 0);
}

DistanceField::DistanceField(const TriangleMesh& mesh, std::span<const double> slack, const TriangleMesh& sheets)
    : has_slack_(!slack.empty()), solid_(mesh.triangles.size()) {
  if (solid_ == 0) throw std::invalid_argument("distance field: the mesh has no triangles");
  if (has_slack_ && slack.size() != solid_) throw std::invalid_argument("distance field: not one slack for each triangle");
  placeFaces(mesh, slack, sheets);
  // Summed in the order of the input, so that the results do not depend on the tree.
  const Vector3d middle = box_.center();
  const auto measures = [&](std::size_t t) {
    const Vector3d a = mesh.corner(t, 0) - middle, b = mesh.corner(t, 1) - middle, c = mesh.corner(t, 2) - middle;
    return std::array<double, 2>{0.5 * (b - a).cross(c - a).norm(), a.dot(b.cross(c)) / 6.0};
  };
  addInOrder<std::array<double, 2>>(solid_, measures,
                                    [&](std::size_t, const std::array<double, 2>& of) { area_ += of[0], volume_ += of[1]; });
  findPseudonormals(mesh);
}

void DistanceField::placeFaces(const TriangleMesh& mesh, std::span<const double> slack, const TriangleMesh& sheets) {
  const std::size_t n = solid_ + sheets.triangles.size();
  const auto corner = [&](std::size_t t, int k) { return t < solid_ ? mesh.corner(t, k) : sheets.corner(t - solid_, k); };
  std::vector<Eigen::AlignedBox3d> boxes(n);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n), [&](const auto& range) {
    for (std::size_t t = range.begin(); t < range.end(); ++t)
      for (int k = 0; k < 3; ++k) boxes[t].extend(corner(t, k));
  });
  for (const Eigen::AlignedBox3d& box : boxes) box_.extend(box);
  diagonal_ = box_.diagonal().norm();
  tree_ = BoxTree(boxes);

  boxes = {};
  corners_.resize(n);
  normal_.resize(n);
  slot_.resize(n);
  if (has_slack_) slack_.resize(n);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n), [&](const auto& range) {
    for (std::size_t s = range.begin(); s < range.end(); ++s) {
      const std::uint32_t t = tree_.order()[s];
      slot_[t] = static_cast<std::uint32_t>(s);
      corners_[s] = {corner(t, 0), corner(t, 1), corner(t, 2)};
      if (has_slack_ && t < solid_) slack_[s] = slack[t];
      const auto& [a, b, c] = corners_[s];
      const Vector3d cross = (b - a).cross(c - a);
      const double length = cross.norm();
      normal_[t] = length > 0 ? Vector3d(cross / length) : Vector3d::Zero();
    }
  });
  tree_.addTriangles(corners_);
}

void DistanceField::findPseudonormals(const TriangleMesh& mesh) {
  const std::vector<std::uint32_t> weld = firstOfEqualPositions(mesh.positions);
  corner_.reserve(solid_);
  first_around_.assign(weld.size() + 1, 0);
  for (const auto& [a, b, c] : mesh.triangles) {
    corner_.push_back({weld[a], weld[b], weld[c]});
    for (const std::uint32_t v : corner_.back()) ++first_around_[v + 1];
  }
  std::partial_sum(first_around_.begin(), first_around_.end(), first_around_.begin());
  around_.resize(3 * solid_);
  std::vector<std::uint32_t> next(first_around_.begin(), first_around_.end() - 1);
  for (std::uint32_t t = 0; t < solid_; ++t)
    for (std::uint32_t k = 0; k < 3; ++k) around_[next[corner_[t][k]]++] = 3 * t + k;
  at_vertex_.assign(weld.size(), Vector3d::Zero());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, weld.size()), [&](const auto& range) {
    for (std::size_t v = range.begin(); v < range.end(); ++v) {
      for (std::uint32_t i = first_around_[v]; i < first_around_[v + 1]; ++i) {
        const std::uint32_t t = around_[i] / 3;
        const std::array<Vector3d, 3>& p = corners(t);
        const std::size_t k = around_[i] % 3;
        const Vector3d e1 = p[(k + 1) % 3] - p[k], e2 = p[(k + 2) % 3] - p[k];
        at_vertex_[v] += std::atan2(e1.cross(e2).norm(), e1.dot(e2)) * normal_[t];
      }
      at_vertex_[v].normalize();
    }
  });
}

template <class Visit>
void DistanceField::visitSides(std::uint32_t a, std::uint32_t b, Visit&& visit) const {
  if (first_around_[b + 1] - first_around_[b] < first_around_[a + 1] - first_around_[a]) std::swap(a, b);
  std::uint32_t last = kNoTriangle;
  for (std::uint32_t i = first_around_[a]; i < first_around_[a + 1]; ++i) {
    const std::uint32_t t = around_[i] / 3;
    if (t == last) continue;  // two of its corners are at this vertex
    last = t;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t from = corner_[t][k], to = corner_[t][(k + 1) % 3];
      if ((from == a && to == b) || (from == b && to == a)) visit(t, k);
    }
  }
}

std::uint32_t DistanceField::across(std::uint32_t triangle, std::size_t k) const {
  if (triangle >= solid_) return kNoTriangle;
  const std::uint32_t from = corner_[triangle][k], to = corner_[triangle][(k + 1) % 3];
  std::uint32_t other = kNoTriangle;
  std::size_t sides = 0;
  visitSides(from, to, [&](std::uint32_t t, std::size_t j) {
    ++sides;
    if (t != triangle && corner_[t][j] == to) other = t;
  });
  return sides == 2 ? other : kNoTriangle;
}

template <bool with_slack, bool with_sheets>
NearestPoint DistanceField::search(const Vector3d& p, double limit) const {
  NearestPoint best;
  double limit2 = limit * limit;
  const std::size_t met = tree_.searchNearest(p, limit2, [&](std::size_t first, std::size_t count) {
    for (std::size_t s = first; s < first + count; ++s) {
      const std::uint32_t triangle = tree_.order()[s];
      if (!with_sheets && triangle >= solid_) continue;
      NearestPoint q = nearestOnTriangle(p, corners_[s][0], corners_[s][1], corners_[s][2]);
      if constexpr (with_slack) q.slack = slack_[s], q.distance += slack_[s];
      if (!(q.distance < limit) && !(q.distance == best.distance && triangle < best.triangle)) continue;
      if (q.distance > best.distance || (q.distance == best.distance && triangle >= best.triangle)) continue;
      best = q;
      best.triangle = triangle;
      limit = best.distance;
      // A few units in the last place above, so that a triangle at exactly this distance is still found, and ties do
      // not depend on the order.
      limit2 = best.distance * best.distance * (1 + 1e-15) + std::numeric_limits<double>::min();
    }
  });
  best.tested = static_cast<std::uint32_t>(met);
  return best;
}

NearestPoint DistanceField::nearest(const Vector3d& p, double limit) const {
  return has_slack_ ? search<true, true>(p, limit) : search<false, true>(p, limit);
}

Vector3d DistanceField::pseudonormal(const NearestPoint& nearest) const {
  if (nearest.triangle >= solid_ || nearest.feature == 0) return normal(nearest.triangle);
  const Triangle& v = corner_[nearest.triangle];
  if (nearest.feature >= 4) return at_vertex_[v[nearest.feature - 4u]];
  Vector3d sum = Vector3d::Zero();  // features 1 to 3 are sides opposite a corner
  visitSides(v[nearest.feature % 3u], v[(nearest.feature + 1u) % 3u], [&](std::uint32_t t, std::size_t) { sum += normal(t); });
  return sum.normalized();
}

bool DistanceField::isInside(const Vector3d& p, const NearestPoint& nearest) const {
  const auto isBehind = [&](const NearestPoint& q) { return (p - q.point).dot(pseudonormal(q)) < 0; };
  if (nearest.triangle >= solid_) return isBehind(search<false, false>(p, kInfinity));
  return isBehind(has_slack_ ? search<false, false>(p, nearest.distance * (1 + 1e-9) + 1e-300) : nearest);
}

double DistanceField::signedDistance(const Vector3d& p, NearestPoint* nearest_out) const {
  const NearestPoint q = nearest(p);
  if (nearest_out) *nearest_out = q;
  return isInside(p, q) ? -q.distance : q.distance;
}

}  // namespace spheretree::builder
