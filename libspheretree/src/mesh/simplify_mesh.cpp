// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/simplify_mesh.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "base/ball.h"
#include "base/sum_in_order.h"
#include "mesh/half_edges.h"
#include "mesh/projected_cover.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kMaxTurn = 0.5;    // cosine of the largest rotation of a triangle in one collapse
constexpr double kMinShape = 0.05;  // twice the area divided by the square of the longest side: triangles below it are slivers
constexpr double kKeptShape = 0.9;  // a collapse leaves a sliver at least this share of that ratio
constexpr std::size_t kMaxNeighbours =
    64;                              // a vertex with more stays until its neighbours have become fewer: its cost is quadratic in them
constexpr double kRoundShare = 0.1;  // largest share of the possible collapses, cheapest first, that a round tries
constexpr std::uint32_t kScatter = 2654435769;  // a multiple of it, modulo 2^32, is far from the next one
constexpr double kMinShare = 0.25;  // of the collapses that claim, made at the same time; if there are fewer, one after the other
constexpr std::size_t kGrain = 1024;
constexpr double kTightShare = 0.25;        // share of the allowed distance: larger bounds of a whole triangle are improved by projection,
constexpr double kLooseness = 1.25;         // ... unless they are below this multiple of a distance that was found
constexpr double kObliqueLooseness = 1.02;  // ... of bounds by oblique projections: parts of the triangle may have smaller ones

/// Sum over planes of area times squared distance: a quadratic form of (x, y, z, 1), the upper half of its matrix, row
/// by row.
using Quadric = Eigen::Matrix<double, 10, 1>;

Quadric planeOf(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d cross = (b - a).cross(c - a);
  const double length = cross.norm();
  if (!(length > 0)) return Quadric::Zero();
  const Vector3d n = cross / length;
  const double d = -n.dot(a);
  Quadric q;
  q << n.x() * n.x(), n.x() * n.y(), n.x() * n.z(), n.x() * d, n.y() * n.y(), n.y() * n.z(), n.y() * d, n.z() * n.z(), n.z() * d, d * d;
  return length * q;
}

/// Mean squared distance of p to the planes. The mean is used because the sum would leave strongly curved places
/// coarse: here the largest distance matters, not the volume between the surfaces.
double errorAt(const Quadric& q, const Vector3d& p) {
  const double x = p.x(), y = p.y(), z = p.z();
  const double sum =
      x * (q[0] * x + 2 * (q[1] * y + q[2] * z + q[3])) + y * (q[4] * y + 2 * (q[5] * z + q[6])) + z * (q[7] * z + 2 * q[8]) + q[9];
  return std::max(0.0, sum) / (q[0] + q[4] + q[7]);
}

}  // namespace

class MeshSimplifier::Collapses {
 public:
  Collapses(const TriangleMesh& mesh, Progress& progress)
      : progress_(progress),
        edges_(std::in_place, mesh.triangles, mesh.positions.size()),
        vertex_(mesh.positions.size()),
        left_(mesh.triangles.size()) {
    std::iota(vertex_.begin(), vertex_.end(), 0u);
    // In a frame of size 1 relative to the middle: far from the origin, the constant terms of the quadrics would exceed
    // their error.
    Eigen::AlignedBox3d box;
    for (const Vector3d& p : mesh.positions) box.extend(p);
    if (box.diagonal().norm() > 0) scale_ = box.diagonal().norm();
    points_.reserve(mesh.positions.size());
    for (const Vector3d& p : mesh.positions) points_.push_back((p - box.center()) / scale_);
    quadrics_.assign(points_.size(), Quadric::Zero());
    const auto plane = [&](std::size_t t) {
      const auto [a, b, c] = mesh.triangles[t];
      return planeOf(points_[a], points_[b], points_[c]);
    };
    addInOrder<Quadric>(mesh.triangles.size(), plane, [&](std::size_t t, const Quadric& q) {
      for (const std::uint32_t v : mesh.triangles[t]) quadrics_[v] += q;
    });
    begin();
  }

  std::vector<Triangle> run(std::size_t wanted, double max_error) {
    max_cost_ = max_error / scale_ * (max_error / scale_);
    const double from = static_cast<double>(left_);
    while (left_ > wanted) {
      progress_.advance(std::log(from / static_cast<double>(left_)) /
                        std::log(from / static_cast<double>(std::max<std::size_t>(wanted, 1))));
      const std::size_t removed = round(left_ - wanted);
      left_ -= removed;
      if (tried_ == 0) break;
    }
    return dropRemoved();
  }

  std::vector<Triangle> remove(std::span<const std::uint32_t> vertices) {
    max_cost_ = kInfinity;
    for (const std::uint32_t v : vertices) {
      best_[v] = cheapest(v);
      if (!(best_[v].cost < kInfinity) || !edges_->canCollapse(best_[v].half_edge)) continue;
      collapse(v);
      left_ -= 2;
    }
    return dropRemoved();
  }

  std::size_t triangles() const { return left_; }
  const std::vector<std::uint32_t>& vertex() const { return vertex_; }

  void rename(std::span<const std::uint32_t> vertex, double scale) {
    for (std::uint32_t& v : vertex_) v = vertex[v];
    scale_ *= scale;
  }

 private:
  struct Collapse {
    std::uint32_t half_edge = 0;  // its start vertex moves to its end vertex
    double cost = kInfinity;
  };
  struct Candidate {
    double cost;
    std::uint32_t tie;  // in flat faces all cost nothing: in the order of the vertices, each would wait for the one beside it
    std::uint32_t vertex;
    auto operator<=>(const Candidate&) const = default;
  };

  /// The neighbours of a vertex that is not on a border, in their order around it, and what does not depend on where it
  /// moves.
  struct Star {
    std::size_t count = 0;
    std::array<std::uint32_t, kMaxNeighbours> half_edge, neighbour;
    std::array<Vector3d, kMaxNeighbours> normal;  // twice the area, of the triangle of a neighbour and the next
  };

  /// True if no triangle of the star of `p` turns over or becomes a sliver when `p` moves to a neighbour.
  bool keepsShape(const Star& star, const Vector3d& p, std::uint32_t to) const {
    const Vector3d& q = points_[to];
    for (std::size_t i = 0; i < star.count; ++i) {
      const std::uint32_t vb = star.neighbour[i], vc = star.neighbour[i + 1 == star.count ? 0 : i + 1];
      if (vb == to || vc == to) continue;
      const Vector3d b = points_[vb], c = points_[vc], after = (b - q).cross(c - q);
      const double n2 = star.normal[i].squaredNorm(), m2 = after.squaredNorm(), dot = star.normal[i].dot(after);
      if (!(dot > 0) || dot * dot < kMaxTurn * kMaxTurn * n2 * m2) return false;
      const double side2 = (c - b).squaredNorm();
      const double longest2 = std::max({side2, (b - q).squaredNorm(), (c - q).squaredNorm()});
      if (m2 >= kMinShape * kMinShape * longest2 * longest2) continue;
      const double longest2_before = std::max({side2, (b - p).squaredNorm(), (c - p).squaredNorm()});
      if (m2 * longest2_before * longest2_before < kKeptShape * kKeptShape * n2 * longest2 * longest2) return false;
    }
    return true;
  }

  Collapse cheapest(std::uint32_t v) const {
    if (edges_->isIsolated(v) || edges_->isBorder(v)) return Collapse();
    Star star;
    bool is_hub = false;
    edges_->visitFrom(v, [&](std::uint32_t h) {
      if (is_hub || (is_hub = star.count == kMaxNeighbours)) return;
      star.half_edge[star.count] = h;
      star.neighbour[star.count++] = edges_->to(h);
    });
    if (is_hub) return Collapse();
    const Vector3d p = points_[v];
    for (std::size_t i = 0; i < star.count; ++i)
      star.normal[i] = (points_[star.neighbour[i]] - p).cross(points_[star.neighbour[i + 1 == star.count ? 0 : i + 1]] - p);
    std::array<std::pair<double, std::uint32_t>, kMaxNeighbours> possible;  // costs, neighbours
    std::size_t count = 0;
    for (std::uint32_t i = 0; i < star.count; ++i) {
      const std::uint32_t to = star.neighbour[i];
      const double cost = errorAt(quadrics_[v] + quadrics_[to], points_[to]);
      if (cost <= max_cost_) possible[count++] = {cost, i};
    }
    // The shape costs more to test than the error: that of the cheapest first.
    const auto before = [&](const auto& a, const auto& b) {
      return std::pair(a.first, star.neighbour[a.second]) < std::pair(b.first, star.neighbour[b.second]);
    };
    for (auto first = possible.begin(), last = first + count; first != last; ++first) {
      std::iter_swap(first, std::min_element(first, last, before));
      if (keepsShape(star, p, star.neighbour[first->second])) return {star.half_edge[first->second], first->first};
    }
    return Collapse();
  }

  template <class One>
  static void each(std::size_t count, One&& one) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kGrain), [&](const auto& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) one(i);
    });
  }

  /// The cheapest of the possible collapses, in their order.
  std::vector<Candidate> candidates() {
    std::erase_if(left_vertices_, [&](std::uint32_t v) { return edges_->isIsolated(v); });
    each(left_vertices_.size(), [&](std::size_t i) {
      const std::uint32_t v = left_vertices_[i];
      if (needs_update_[v]) best_[v] = cheapest(v), needs_update_[v] = 0;
    });
    std::vector<Candidate> order;
    for (const std::uint32_t v : left_vertices_)
      if (best_[v].cost < kInfinity) order.push_back({best_[v].cost, v * kScatter, v});
    tried_ = static_cast<std::size_t>(std::ceil(kRoundShare * static_cast<double>(order.size())));
    if (tried_ == 0) return {};
    std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(tried_ - 1), order.end());
    order.resize(tried_);
    tbb::parallel_sort(order.begin(), order.end());
    return order;
  }

  /// Makes the best collapse of `v`; returns its end.
  std::uint32_t collapse(std::uint32_t v) {
    const std::uint32_t end = edges_->to(best_[v].half_edge);
    edges_->collapse(best_[v].half_edge);
    quadrics_[end] += quadrics_[v];
    return end;
  }

  template <class Visit>
  void visitAround(std::uint32_t v, Visit&& visit) const {
    visit(v);
    edges_->visitFrom(v, [&](std::uint32_t h) { visit(edges_->to(h)); });
  }

  void outdateAround(std::uint32_t end) {
    visitAround(end, [&](std::uint32_t v) { std::atomic_ref(needs_update_[v]).store(1, std::memory_order_relaxed); });
  }

  /// One round of collapses that do not touch each other; returns the number of removed triangles, at most about
  /// `limit`. Each collapse claims its vertex and the neighbours, and is made if no cheaper one claims any of them.
  /// That is repeated with those that are left: what is made is what would be made in the order of the costs. Around a
  /// vertex of many triangles only one could be made at a time: then the others follow one after the other.
  std::size_t round(std::size_t limit) {
    progress_.check();
    std::vector<Candidate> open = candidates();
    std::vector<char> wins;
    std::size_t removed = 0;
    const auto claimed = [&](std::uint32_t v) { return std::atomic_ref(claim_[v]); };
    while (!open.empty() && removed < limit) {
      --epoch_;
      const auto claimOf = [&](std::size_t i) { return std::uint64_t{epoch_} << 32 | i; };
      each(open.size(), [&](std::size_t i) {
        visitAround(open[i].vertex, [&](std::uint32_t v) {
          std::uint64_t before = claimed(v).load(std::memory_order_relaxed);
          while (claimOf(i) < before && !claimed(v).compare_exchange_weak(before, claimOf(i), std::memory_order_relaxed)) {
          }
        });
      });
      wins.assign(open.size(), 0);
      each(open.size(), [&](std::size_t i) {
        bool is_first = true;
        visitAround(open[i].vertex, [&](std::uint32_t v) { is_first = is_first && claim_[v] == claimOf(i); });
        Collapse& best = best_[open[i].vertex];
        if (is_first && !edges_->canCollapse(best.half_edge)) best.cost = kInfinity;  // until its surroundings change
        wins[i] = is_first && best.cost < kInfinity;
      });
      std::vector<std::uint32_t> made, ends;
      for (std::size_t i = 0; i < open.size() && removed < limit; ++i)
        if (wins[i]) made.push_back(open[i].vertex), removed += 2;
      ends.resize(made.size());
      each(made.size(), [&](std::size_t i) { ends[i] = collapse(made[i]); });
      each(ends.size(), [&](std::size_t i) { outdateAround(ends[i]); });
      const bool is_slow = static_cast<double>(made.size()) < kMinShare * static_cast<double>(open.size());
      std::erase_if(open, [&](const Candidate& c) {
        return edges_->isIsolated(c.vertex) || needs_update_[c.vertex] || best_[c.vertex].cost == kInfinity;
      });
      if (is_slow) break;
    }
    for (std::size_t i = 0; i < open.size() && removed < limit; ++i) {
      const std::uint32_t v = open[i].vertex;
      if (needs_update_[v]) continue;
      if (!edges_->canCollapse(best_[v].half_edge)) {
        best_[v].cost = kInfinity;
        continue;
      }
      outdateAround(collapse(v));
      needs_update_[v] = 1;
      removed += 2;
    }
    return removed;
  }

  // Forgets the triangles and vertices that were removed, and returns the triangles that are left.
  std::vector<Triangle> dropRemoved() {
    std::vector<std::uint32_t> place(points_.size());
    std::uint32_t count = 0;
    for (std::uint32_t v = 0; v < points_.size(); ++v) {
      if (edges_->isIsolated(v)) continue;
      place[v] = count;
      vertex_[count] = vertex_[v], points_[count] = points_[v], quadrics_[count] = quadrics_[v];
      ++count;
    }
    std::vector<Triangle> triangles = edges_->triangles();
    for (Triangle& t : triangles)
      for (std::uint32_t& v : t) v = place[v];
    edges_.emplace(triangles, count);
    vertex_.resize(count), points_.resize(count), quadrics_.resize(count);
    vertex_.shrink_to_fit(), points_.shrink_to_fit(), quadrics_.shrink_to_fit();
    begin();
    return triangles;
  }

  void begin() {
    const std::size_t count = points_.size();
    best_ = std::vector<Collapse>(count);
    needs_update_ = std::vector<char>(count, 1);
    claim_ = std::vector<std::uint64_t>(count, std::numeric_limits<std::uint64_t>::max());
    epoch_ = std::numeric_limits<std::uint32_t>::max();
    left_vertices_.resize(count);
    std::iota(left_vertices_.begin(), left_vertices_.end(), 0u);
  }

  Progress& progress_;
  std::optional<HalfEdges> edges_;     // begun anew by emplace(): OpenMesh copies where others move, and keeps the memory
  std::vector<std::uint32_t> vertex_;  // (vertices) index in the mesh
  std::vector<Vector3d> points_;
  std::vector<Quadric> quadrics_;
  std::vector<Collapse> best_;
  std::vector<char> needs_update_;            // (vertices) whether best_ is outdated
  std::vector<std::uint64_t> claim_;          // (vertices) the smallest number of a collapse that claims it; later ones are smaller
  std::uint32_t epoch_ = 0;                   // upper half of the numbers of claims
  std::vector<std::uint32_t> left_vertices_;  // ascending
  std::size_t tried_ = 0;                     // collapses of the last round; each was made, or turned out to be impossible
  std::size_t left_;                          // triangles
  double scale_ = 1;                          // size of the mesh [mm]
  double max_cost_ = kInfinity;               // largest cost of a collapse
};

// --- the bound ---

namespace {

struct Corner {
  Vector3d p;
  double distance;
  std::uint32_t nearest;  // triangle of the field
  std::uint8_t feature;   // of the triangle
};

Corner cornerAt(const DistanceField& field, const Vector3d& p) {
  const NearestPoint nearest = field.nearest(p);
  return {p, nearest.distance, nearest.triangle, nearest.feature};
}

/// For one thread.
class PieceBound {
 public:
  /// A bound of at most `tight` is not improved. No point with a distance of up to `floor` matters: some point has it.
  PieceBound(const DistanceField& field, double allowed, double sufficient_bound, double tight, double floor)
      : field_(field), cover_(field), allowed_(allowed), sufficient_bound_(sufficient_bound), tight_(tight), floor_(floor) {}

  /// Upper bound of the distance over a triangle: at most the allowed distance if a few pieces can show it. Infinite if
  /// a point is farther than `sufficient_bound`.
  double run(const std::array<Corner, 3>& triangle) {
    double bound = 0;
    std::size_t pieces = 1;
    found_ = 0;
    for (const Corner& c : triangle) found_ = std::max(found_, c.distance);
    stack_.assign(1, triangle);
    while (!stack_.empty()) {
      const std::array<Corner, 3> piece = stack_.back();
      stack_.pop_back();
      const double here = boundOf(piece, pieces == 1);
      if (here == kInfinity) return here;
      if (isTight(here) || pieces >= kMaxPieces) {
        bound = std::max(bound, here);
        continue;
      }
      ++pieces;
      std::size_t k = 0;  // opposite the longest side
      for (std::size_t j = 1; j < 3; ++j)
        if (side2(piece, j) > side2(piece, k)) k = j;
      const Corner halfway = cornerAt(field_, 0.5 * (piece[(k + 1) % 3].p + piece[(k + 2) % 3].p));
      if (halfway.distance > sufficient_bound_) return kInfinity;
      found_ = std::max(found_, halfway.distance);
      for (const std::size_t replaced : {1, 2}) {
        stack_.push_back(piece);
        stack_.back()[(k + replaced) % 3] = halfway;
      }
    }
    return bound;
  }

 private:
  static constexpr std::size_t kMaxPieces = 1024;
  bool isTight(double bound) const { return bound <= std::max(tight_, std::min(allowed_, kLooseness * found_)); }
  static double side2(const std::array<Corner, 3>& piece, std::size_t opposite) {
    return (piece[(opposite + 1) % 3].p - piece[(opposite + 2) % 3].p).squaredNorm();
  }

  /// Infinite if a point is farther than `sufficient_bound`. A part of the triangle is one because no projection gave a
  /// bound: then the triangles that are nearest to its corners come first, as far as that makes no bound looser.
  double boundOf(const std::array<Corner, 3>& piece, bool is_whole) {
    const std::array<std::uint32_t, 3> face{piece[0].nearest, piece[1].nearest, piece[2].nearest};
    // The distance to one triangle is convex, and the distance to all is 1-Lipschitz.
    if (face[0] == face[1] && face[1] == face[2]) return std::max({piece[0].distance, piece[1].distance, piece[2].distance});
    double smallest = kInfinity;
    for (std::size_t k = 0; k < 3; ++k)
      smallest = std::min(smallest, piece[k].distance + std::sqrt(std::max(side2(piece, (k + 1) % 3), side2(piece, (k + 2) % 3))));
    const std::array<Vector3d, 3> corners{piece[0].p, piece[1].p, piece[2].p};
    if (is_whole && !isTight(smallest)) smallest = std::min(smallest, boundByProjections(piece));
    if (!isTight(smallest)) smallest = std::min(smallest, boundByFaces(corners, face));
    if (!is_whole && smallest > std::max(tight_, found_)) smallest = std::min(smallest, boundByProjections(piece));
    return found_ > sufficient_bound_ ? kInfinity : smallest;
  }

  /// Along the normal of the piece; if that is of no use, along the mean normal of the surface at the corners. Beside a
  /// crease, what lies over the piece along its own normal includes the wall beyond the crease.
  double boundByProjections(const std::array<Corner, 3>& piece) {
    const std::array<Vector3d, 3> corners{piece[0].p, piece[1].p, piece[2].p};
    const std::array<std::uint32_t, 3> face{piece[0].nearest, piece[1].nearest, piece[2].nearest};
    const double smallest = boundByProjection(corners, (corners[1] - corners[0]).cross(corners[2] - corners[0]), face);
    if (isTight(smallest) || found_ > sufficient_bound_) return smallest;
    Vector3d outward = Vector3d::Zero();
    for (const Corner& c : piece) outward += field_.pseudonormal({.triangle = c.nearest, .feature = c.feature});
    const double before = found_;
    const double oblique = boundByProjection(corners, outward, face);
    const double known = cover_.farthest() ? std::max(found_, field_.distance(*cover_.farthest())) : found_;
    found_ = known > sufficient_bound_ ? known : before;  // a larger one would let looser bounds of pieces pass
    return oblique <= kObliqueLooseness * std::max(floor_, known) ? std::min(smallest, oblique) : smallest;
  }

  /// From the triangles that are nearest to the corners and to the centroid: they may lie beside the piece.
  double boundByProjection(const std::array<Vector3d, 3>& corners, const Vector3d& along, const std::array<std::uint32_t, 3>& face) {
    const std::uint32_t searches = cover_.searches();
    double smallest = kInfinity;
    for (std::size_t i = 0; i < 4 && !isTight(smallest) && found_ <= sufficient_bound_; ++i) {
      const std::uint32_t start = i < 3 ? face[i] : field_.nearest((corners[0] + corners[1] + corners[2]) / 3).triangle;
      if (cover_.hasMet(start, searches)) continue;
      smallest = std::min(smallest, cover_.distance(corners, along, start, floor_, allowed_));
      if (!isTight(smallest) && cover_.farthest()) found_ = std::max(found_, field_.distance(*cover_.farthest()));
    }
    return smallest;
  }

  double boundByFaces(const std::array<Vector3d, 3>& corners, const std::array<std::uint32_t, 3>& face) const {
    std::array<std::array<Vector3d, 3>, 3> on;           // corners of each face
    std::array<std::array<NearestPoint, 3>, 3> nearest;  // on each face, of each corner of the piece
    double smallest = kInfinity;
    for (std::size_t k = 0; k < 3; ++k) {
      on[k] = field_.corners(face[k]);
      double to_one = 0;
      for (std::size_t j = 0; j < 3; ++j) {
        nearest[k][j] = nearestOnTriangle(corners[j], on[k][0], on[k][1], on[k][2]);
        to_one = std::max(to_one, nearest[k][j].distance);
      }
      smallest = std::min(smallest, to_one);
    }
    for (std::size_t k = 0; k < 3 && !isTight(smallest); ++k) {
      const std::size_t next = (k + 1) % 3;
      if (face[k] != face[next]) smallest = std::min(smallest, boundByTwo(on[k], on[next], nearest[k], nearest[next]));
    }
    return smallest;
  }

  /// If the corners are nearest to two triangles, which may be steep over the piece: the nearest points of the
  /// corners span a triangle whose distance from the piece is at most that of the corners. One of its corners, a,
  /// lies on one face, and b and c on the other. A path on the two faces leads from a to b, and one from a to c,
  /// through any point that the faces share. The distance of the triangle a, b, c from the faces is at most the
  /// distance of its sides ab and ac from a point where those paths bend.
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
  ProjectedCover cover_;
  double allowed_, sufficient_bound_, tight_, floor_;
  double found_ = 0;  // largest distance of a point of the triangle that was met
  std::vector<std::array<Corner, 3>> stack_;
};

}  // namespace

MeshSimplifier::MeshSimplifier(const TriangleMesh& mesh, Progress& progress)
    : mesh_(&mesh), collapses_(std::make_unique<Collapses>(mesh, progress)) {}
MeshSimplifier::~MeshSimplifier() = default;
std::size_t MeshSimplifier::triangles() const { return collapses_->triangles(); }

TriangleMesh MeshSimplifier::reduce(std::size_t triangles, double max_error) { return withVertices(collapses_->run(triangles, max_error)); }

TriangleMesh MeshSimplifier::remove(std::span<const std::uint32_t> vertices) { return withVertices(collapses_->remove(vertices)); }

TriangleMesh MeshSimplifier::withVertices(std::vector<Triangle> triangles) const {
  TriangleMesh result;
  result.triangles = std::move(triangles);
  for (const std::uint32_t v : collapses_->vertex()) result.positions.push_back(mesh_->positions[v]);
  return result;
}

void MeshSimplifier::moveTo(const TriangleMesh& mesh, std::span<const std::uint32_t> vertex, double scale) {
  mesh_ = &mesh;
  collapses_->rename(vertex, scale);
}

TriangleMesh simplifyMesh(const TriangleMesh& mesh, std::size_t triangles, Progress& progress, double max_error) {
  return MeshSimplifier(mesh, progress).reduce(triangles, max_error);
}

double distanceBound(const TriangleMesh& mesh, const DistanceField& field, Progress& progress, double sufficient_bound) {
  std::vector<Corner> corners(mesh.positions.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, corners.size(), kGrain), [&](const auto& range) {
    progress.check();
    for (std::size_t v = range.begin(); v < range.end(); ++v) corners[v] = cornerAt(field, mesh.positions[v]);
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
  tbb::enumerable_thread_specific<PieceBound> piece_bounds([&] { return PieceBound(field, allowed, sufficient, tight, largest); });
  std::vector<double> bounds((mesh.triangles.size() + kGrain - 1) / kGrain);
  tbb::parallel_for(std::size_t{0}, bounds.size(), [&](std::size_t chunk) {
    progress.check();
    if (is_beyond) return;
    PieceBound& piece_bound = piece_bounds.local();
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
