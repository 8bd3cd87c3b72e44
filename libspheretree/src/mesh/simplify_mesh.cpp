// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/simplify_mesh.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "mesh/projected_cover.h"

#include "base/ball.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kMaxTurn = 0.5;    // cosine of the largest rotation of a triangle in one collapse
constexpr double kMinShape = 0.05;  // twice the area divided by the square of the longest side: triangles below it are slivers
constexpr double kKeptShape = 0.9;  // a collapse leaves a sliver at least this share of that ratio
constexpr std::size_t kMaxNeighbours =
    64;                                // a vertex with more stays until its neighbours have become fewer: its cost is quadratic in them
constexpr double kRoundShare = 0.1;    // largest share of the possible collapses, cheapest first, that a round tries
constexpr double kMinProgress = 0.01;  // share of the triangles that a round must remove; otherwise the reduction ends
constexpr std::size_t kGrain = 4096;
constexpr double kTightShare = 0.25;  // share of the allowed distance: larger bounds of a whole triangle are improved by projection,
constexpr double kLooseness = 1.25;   // ... unless they are below this multiple of a distance that was found

using Connectivity = OpenMesh::TriMesh_ArrayKernelT<>;
using Vertex = OpenMesh::VertexHandle;
using Halfedge = OpenMesh::HalfedgeHandle;

Vertex vertexOf(std::size_t i) { return Vertex(static_cast<int>(i)); }

/// Sum over planes of area times squared distance: the symmetric matrix of the quadratic form (x, 1).
using Quadric = Eigen::Matrix4d;

Quadric planeOf(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d n = (b - a).cross(c - a);
  const double length = n.norm();
  if (!(length > 0)) return Quadric::Zero();
  Eigen::Vector4d plane;
  plane << n / length, -n.dot(a) / length;
  return length * plane * plane.transpose();
}

double areaOf(const Quadric& q) { return q(0, 0) + q(1, 1) + q(2, 2); }

/// Mean squared distance of p to the planes. The mean is used because the sum would leave strongly curved places
/// coarse: here the largest distance matters, not the volume between the surfaces.
double errorAt(const Quadric& q, const Vector3d& p) {
  const Eigen::Vector4d x = p.homogeneous();
  return std::max(0.0, x.dot(q * x)) / areaOf(q);
}

}  // namespace

class MeshSimplifier::Collapses {
 public:
  Collapses(const TriangleMesh& mesh, Progress& progress) : mesh_(mesh), progress_(progress), left_(mesh.triangles.size()) {
    connect();
    // In a frame of size 1 relative to the middle: far from the origin, the constant terms of the quadrics would exceed
    // their error.
    Eigen::AlignedBox3d box;
    for (const Vector3d& p : mesh.positions) box.extend(p);
    if (box.diagonal().norm() > 0) scale_ = box.diagonal().norm();
    points_.reserve(mesh.positions.size());
    for (const Vector3d& p : mesh.positions) points_.push_back((p - box.center()) / scale_);
    quadrics_.assign(points_.size(), Quadric::Zero());
    for (const Triangle& t : mesh.triangles) {
      const Quadric q = planeOf(points_[t[0]], points_[t[1]], points_[t[2]]);
      for (const std::uint32_t v : t) quadrics_[v] += q;
    }
    best_.resize(points_.size());
    needs_update_.assign(points_.size(), 1);
  }

  TriangleMesh run(std::size_t wanted, double max_error) {
    max_cost_ = max_error / scale_ * (max_error / scale_);
    for (std::size_t v = 0; v < best_.size(); ++v)
      if (!(best_[v].cost < kInfinity)) needs_update_[v] = 1;  // it may have been beyond an earlier limit
    const double from = static_cast<double>(left_);
    while (left_ > wanted) {
      progress_.advance(std::log(from / static_cast<double>(left_)) /
                        std::log(from / static_cast<double>(std::max<std::size_t>(wanted, 1))));
      const std::size_t removed = round(left_ - wanted);
      left_ -= removed;
      if (static_cast<double>(removed) < kMinProgress * static_cast<double>(left_)) break;
    }
    return collect();
  }

 private:
  struct Collapse {
    Halfedge halfedge;  // its start vertex moves to its end vertex
    double cost = kInfinity;
  };

  void connect() {
    connectivity_.reserve(mesh_.positions.size(), mesh_.triangles.size() * 3 / 2, mesh_.triangles.size());
    for (std::size_t i = 0; i < mesh_.positions.size(); ++i) connectivity_.new_vertex();
    omerr().disable();  // the caller reports a refusal
    for (const Triangle& t : mesh_.triangles)
      if (!connectivity_.add_face(vertexOf(t[0]), vertexOf(t[1]), vertexOf(t[2])).is_valid())
        throw std::invalid_argument("simplify: the mesh is not manifold");
    connectivity_.request_vertex_status();
    connectivity_.request_edge_status();
    connectivity_.request_halfedge_status();
    connectivity_.request_face_status();
  }

  const Vector3d& at(Vertex v) const { return points_[static_cast<std::size_t>(v.idx())]; }

  /// True if no triangle at the start of `h` turns over or becomes a sliver.
  bool keepsShape(Halfedge h) const {
    const Vertex from = connectivity_.from_vertex_handle(h), to = connectivity_.to_vertex_handle(h);
    const Vector3d &p = at(from), &q = at(to);
    for (const auto side : connectivity_.voh_range(from)) {
      if (connectivity_.is_boundary(side)) continue;
      const Vertex b = connectivity_.to_vertex_handle(side), c = connectivity_.to_vertex_handle(connectivity_.next_halfedge_handle(side));
      if (b == to || c == to) continue;
      const Vector3d bc = at(c) - at(b);
      const Vector3d before = (at(b) - p).cross(at(c) - p), after = (at(b) - q).cross(at(c) - q);
      const double n2 = before.squaredNorm(), m2 = after.squaredNorm(), dot = before.dot(after);
      if (!(dot > 0) || dot * dot < kMaxTurn * kMaxTurn * n2 * m2) return false;
      const double longest2 = std::max({bc.squaredNorm(), (at(b) - q).squaredNorm(), (at(c) - q).squaredNorm()});
      const double longest2_before = std::max({bc.squaredNorm(), (at(b) - p).squaredNorm(), (at(c) - p).squaredNorm()});
      if (m2 < kMinShape * kMinShape * longest2 * longest2 &&
          m2 * longest2_before * longest2_before < kKeptShape * kKeptShape * n2 * longest2 * longest2)
        return false;
    }
    return true;
  }

  Collapse cheapest(Vertex v) const {
    if (connectivity_.status(v).deleted() || connectivity_.is_isolated(v) || connectivity_.is_boundary(v)) return Collapse();
    std::array<Collapse, kMaxNeighbours> possible;
    std::size_t count = 0, neighbours = 0;
    for (const auto h : connectivity_.voh_range(v)) {
      if (++neighbours > kMaxNeighbours) return Collapse();
      const auto to = static_cast<std::size_t>(connectivity_.to_vertex_handle(h).idx());
      const double cost = errorAt(quadrics_[static_cast<std::size_t>(v.idx())] + quadrics_[to], points_[to]);
      if (cost <= max_cost_) possible[count++] = {h, cost};
    }
    // The shape costs more to test than the error: that of the cheapest first.
    for (auto first = possible.begin(), last = first + count; first != last; ++first) {
      std::iter_swap(first, std::min_element(first, last, [](const Collapse& a, const Collapse& b) {
                       return a.cost < b.cost || (a.cost == b.cost && a.halfedge.idx() < b.halfedge.idx());
                     }));
      if (keepsShape(first->halfedge)) return *first;
    }
    return Collapse();
  }

  /// One round of collapses that do not touch each other; returns the number of removed triangles, at most about
  /// `limit`.
  std::size_t round(std::size_t limit) {
    progress_.check();
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points_.size(), kGrain), [&](const auto& range) {
      for (std::size_t v = range.begin(); v < range.end(); ++v)
        if (needs_update_[v]) best_[v] = cheapest(vertexOf(v)), needs_update_[v] = 0;
    });
    std::vector<std::uint32_t> order;
    for (std::uint32_t v = 0; v < best_.size(); ++v)
      if (best_[v].cost < kInfinity) order.push_back(v);
    const auto before = [&](std::uint32_t a, std::uint32_t b) {
      return best_[a].cost < best_[b].cost || (best_[a].cost == best_[b].cost && a < b);
    };
    const auto tried = static_cast<std::ptrdiff_t>(std::ceil(kRoundShare * static_cast<double>(order.size())));
    std::nth_element(order.begin(), order.begin() + std::max<std::ptrdiff_t>(tried - 1, 0), order.end(), before);
    order.resize(static_cast<std::size_t>(tried));
    std::sort(order.begin(), order.end(), before);
    std::size_t removed = 0;
    for (const std::uint32_t v : order) {
      if (removed >= limit) break;
      const Halfedge h = best_[v].halfedge;
      if (needs_update_[v]) continue;
      if (!connectivity_.is_collapse_ok(h)) {
        best_[v].cost = kInfinity;  // until its surroundings change
        continue;
      }
      const Vertex to = connectivity_.to_vertex_handle(h);
      connectivity_.collapse(h);
      removed += 2;
      quadrics_[static_cast<std::size_t>(to.idx())] += quadrics_[v];
      needs_update_[v] = needs_update_[static_cast<std::size_t>(to.idx())] = 1;
      for (const auto near : connectivity_.vv_range(to)) needs_update_[static_cast<std::size_t>(near.idx())] = 1;
    }
    return removed;
  }

  TriangleMesh collect() {
    TriangleMesh result;
    std::vector<std::uint32_t> index(points_.size());
    for (std::size_t v = 0; v < points_.size(); ++v) {
      if (connectivity_.status(vertexOf(v)).deleted() || connectivity_.is_isolated(vertexOf(v))) continue;
      index[v] = static_cast<std::uint32_t>(result.positions.size());
      result.positions.push_back(mesh_.positions[v]);
    }
    for (const auto face : connectivity_.faces()) {
      Triangle t;
      std::size_t k = 0;
      for (const auto v : connectivity_.fv_range(face)) t[k++] = index[static_cast<std::size_t>(v.idx())];
      result.triangles.push_back(t);
    }
    return result;
  }

  const TriangleMesh& mesh_;
  Progress& progress_;
  std::size_t left_;             // triangles
  double scale_ = 1;             // size of the mesh [mm]
  double max_cost_ = kInfinity;  // largest cost of a collapse
  Connectivity connectivity_;
  std::vector<Vector3d> points_;
  std::vector<Quadric> quadrics_;
  std::vector<Collapse> best_;
  std::vector<char> needs_update_;  // (vertices) whether best_ is outdated
};

// --- the bound ---

namespace {

struct Corner {
  Vector3d p;
  double distance;
  std::uint32_t nearest;  // triangle of the field
};

class PieceBound {
 public:
  /// A bound of a whole triangle that is at most `tight` is not improved, and no bound that is at most `floor`: that is
  /// the distance of some point.
  PieceBound(const DistanceField& field, double allowed, double sufficient_bound, double tight, double floor)
      : field_(field), allowed_(allowed), sufficient_bound_(sufficient_bound), tight_(tight), floor_(floor) {}

  /// Upper bound of the distance over a triangle: at most the allowed distance if a few pieces can show it. Infinite if
  /// a point is farther than `sufficient_bound`.
  double run(const std::array<Corner, 3>& triangle) {
    double bound = boundOf(triangle);
    if (bound <= tight_) return bound;
    bound = 0;
    stack_.assign(1, triangle);
    if (sufficient_bound_ < kInfinity) {
      const ProjectedCover cover = coverByProjection({triangle[0].p, triangle[1].p, triangle[2].p}, field_, allowed_);
      bound = cover.distance;
      stack_.clear();
      for (const auto& [a, b, c] : cover.not_covered) stack_.push_back({corner(a), corner(b), corner(c)});
    }
    std::size_t pieces = stack_.size();
    while (!stack_.empty()) {
      const std::array<Corner, 3> piece = stack_.back();
      stack_.pop_back();
      const double here = boundOf(piece);
      if (here <= allowed_ || pieces >= kMaxPieces) {
        bound = std::max(bound, here);
        continue;
      }
      ++pieces;
      std::size_t k = 0;  // opposite the longest side
      for (std::size_t j = 1; j < 3; ++j)
        if (side2(piece, j) > side2(piece, k)) k = j;
      const Corner halfway = corner(0.5 * (piece[(k + 1) % 3].p + piece[(k + 2) % 3].p));
      if (halfway.distance > sufficient_bound_) return kInfinity;
      for (const std::size_t replaced : {1, 2}) {
        stack_.push_back(piece);
        stack_.back()[(k + replaced) % 3] = halfway;
      }
    }
    return bound;
  }

  Corner corner(const Vector3d& p) const {
    const NearestPoint nearest = field_.nearest(p);
    return {p, nearest.distance, nearest.triangle};
  }

 private:
  static constexpr std::size_t kMaxPieces = 1024;
  static double side2(const std::array<Corner, 3>& piece, std::size_t opposite) {
    return (piece[(opposite + 1) % 3].p - piece[(opposite + 2) % 3].p).squaredNorm();
  }
  /// Ends early with a bound of at most `floor_`, since no better one is of use.
  double boundOf(const std::array<Corner, 3>& piece) const {
    const std::array<std::uint32_t, 3> face{piece[0].nearest, piece[1].nearest, piece[2].nearest};
    if (face[0] == face[1] && face[1] == face[2]) return std::max({piece[0].distance, piece[1].distance, piece[2].distance});
    std::array<std::array<Vector3d, 3>, 3> corners;      // of each face
    std::array<std::array<NearestPoint, 3>, 3> nearest;  // on each face, of each corner of the piece
    double smallest = kInfinity;
    for (std::size_t k = 0; k < 3; ++k) {
      // The distance is 1-Lipschitz, and that to one triangle is convex.
      const std::size_t next = (k + 1) % 3, last = (k + 2) % 3;
      smallest = std::min(smallest, piece[k].distance + std::max((piece[next].p - piece[k].p).norm(), (piece[last].p - piece[k].p).norm()));
      corners[k] = field_.corners(face[k]);
      double to_one = 0;
      for (std::size_t j = 0; j < 3; ++j) {
        nearest[k][j] = nearestOnTriangle(piece[j].p, corners[k][0], corners[k][1], corners[k][2]);
        to_one = std::max(to_one, nearest[k][j].distance);
      }
      smallest = std::min(smallest, to_one);
      if (smallest <= floor_) return smallest;
    }
    for (std::size_t k = 0; k < 3 && smallest > floor_; ++k) {
      const std::size_t next = (k + 1) % 3;
      if (face[k] != face[next]) smallest = std::min(smallest, boundByTwo(corners[k], corners[next], nearest[k], nearest[next]));
    }
    return smallest;
  }

  /// The distance to one triangle is convex, and therefore largest at a corner. If the corners are nearest to two
  /// triangles: the nearest points of the corners span a triangle whose distance from the piece is at most that of the
  /// corners. One of its corners, a, lies on one face, and b and c on the other. A path on the two faces leads from a
  /// to b, and one from a to c, through any point that the faces share. The distance of the triangle a, b, c from the
  /// faces is at most the distance of its sides ab and ac from a point where those paths bend.
  static double boundByTwo(const std::array<Vector3d, 3>& one, const std::array<Vector3d, 3>& two,
                           const std::array<NearestPoint, 3>& on_first, const std::array<NearestPoint, 3>& on_second) {
    std::array<Vector3d, 3> foot;
    std::array<bool, 3> on_one{};
    double largest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      on_one[k] = on_first[k].distance <= on_second[k].distance;
      foot[k] = on_one[k] ? on_first[k].point : on_second[k].point;
      largest = std::max(largest, std::min(on_first[k].distance, on_second[k].distance));
    }
    if (on_one[0] == on_one[1] && on_one[1] == on_one[2]) return largest;
    std::size_t alone = 0;
    while (on_one[alone] == on_one[(alone + 1) % 3] || on_one[alone] == on_one[(alone + 2) % 3]) ++alone;
    std::array<Vector3d, 3> shared;  // corners that both faces share
    std::size_t count = 0;
    for (const Vector3d& p : one)
      if (p == two[0] || p == two[1] || p == two[2]) shared[count++] = p;
    if (count == 0) return kInfinity;
    const Vector3d &a = foot[alone], &b = foot[(alone + 1) % 3], &c = foot[(alone + 2) % 3], &from = shared[0], &to = shared[count - 1];
    return largest + std::max(distanceOfSegments(a, b, from, to), distanceOfSegments(a, c, from, to));
  }

  /// An upper bound of the distance between two segments; exact unless they are nearly parallel.
  static double distanceOfSegments(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
    const Vector3d u = b - a, v = d - c, w = a - c;
    const double uu = u.squaredNorm(), uv = u.dot(v), vv = v.squaredNorm(), uw = u.dot(w), vw = v.dot(w);
    const auto share = [](double numerator, double denominator) {
      return denominator > 0 ? std::clamp(numerator / denominator, 0.0, 1.0) : 0.0;
    };
    double s = share(uv * vw - vv * uw, uu * vv - uv * uv);
    const double t = share(vw + s * uv, vv);
    s = share(t * uv - uw, uu);
    return (w + s * u - t * v).norm();
  }

  const DistanceField& field_;
  double allowed_, sufficient_bound_, tight_, floor_;
  std::vector<std::array<Corner, 3>> stack_;
};

}  // namespace

MeshSimplifier::MeshSimplifier(const TriangleMesh& mesh, Progress& progress) : collapses_(std::make_unique<Collapses>(mesh, progress)) {}
MeshSimplifier::~MeshSimplifier() = default;
TriangleMesh MeshSimplifier::reduce(std::size_t triangles, double max_error) { return collapses_->run(triangles, max_error); }

TriangleMesh simplifyMesh(const TriangleMesh& mesh, std::size_t triangles, Progress& progress, double max_error) {
  return MeshSimplifier(mesh, progress).reduce(triangles, max_error);
}

double distanceBound(const TriangleMesh& mesh, const DistanceField& field, Progress& progress, double sufficient_bound) {
  const PieceBound any(field, 0, sufficient_bound, 0, 0);
  std::vector<Corner> corners(mesh.positions.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, corners.size(), kGrain), [&](const auto& range) {
    progress.check();
    for (std::size_t v = range.begin(); v < range.end(); ++v) corners[v] = any.corner(mesh.positions[v]);
  });
  double largest = 0;
  for (const Corner& c : corners) largest = std::max(largest, c.distance);
  // Upper bound of the rounding error of a distance in double precision.
  const double rounding = 1e-12 * (field.box().min().cwiseAbs().cwiseMax(field.box().max().cwiseAbs()).maxCoeff() + field.diagonal());
  const double sufficient = sufficient_bound - rounding;
  if (largest > sufficient) return kInfinity;
  const double loose = std::max(kLooseness * largest, 1e-6 * field.diagonal());
  const double allowed = sufficient < kInfinity ? sufficient : loose;
  const double tight = sufficient < kInfinity ? std::min(allowed, std::max(kTightShare * allowed, loose)) : allowed;
  std::atomic<bool> is_beyond = false;
  std::vector<double> bounds((mesh.triangles.size() + kGrain - 1) / kGrain);
  tbb::parallel_for(std::size_t{0}, bounds.size(), [&](std::size_t chunk) {
    progress.check();
    PieceBound piece_bound(field, allowed, sufficient, tight, largest);
    if (is_beyond) return;
    for (std::size_t t = chunk * kGrain; t < std::min(mesh.triangles.size(), (chunk + 1) * kGrain); ++t) {
      const Triangle& triangle = mesh.triangles[t];
      bounds[chunk] = std::max(bounds[chunk], piece_bound.run({corners[triangle[0]], corners[triangle[1]], corners[triangle[2]]}));
    }
    if (bounds[chunk] > sufficient) is_beyond = true;
  });
  if (is_beyond) return kInfinity;
  return *std::max_element(bounds.begin(), bounds.end()) + rounding;
}

}  // namespace spheretree::builder
