// SPDX-License-Identifier: GPL-3.0-or-later
#include "repair/resolve_overlaps.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "geometry/winding_number.h"
#include "mesh/crossing_triangles.h"
#include "spheretree/core/mesh_edit.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

using Exact = CGAL::Exact_predicates_exact_constructions_kernel;
using Point3 = Exact::Point_3;
using Point2 = Exact::Point_2;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, Exact>;
using FaceBase = CGAL::Constrained_triangulation_face_base_2<Exact>;
using Plane = CGAL::Constrained_Delaunay_triangulation_2<Exact, CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>,
                                                         CGAL::Exact_intersections_tag>;

constexpr std::uint32_t kNone = kAddedTriangle;

/// The points of a cut mesh: exact, without duplicates, numbered.
class ExactPoints {
 public:
  std::uint32_t indexOf(const Point3& p) {
    const auto [at, is_new] = index_.try_emplace(p, static_cast<std::uint32_t>(points_.size()));
    if (is_new) points_.push_back(p);
    return at->second;
  }
  const Point3& operator[](std::size_t i) const { return points_[i]; }
  std::size_t size() const { return points_.size(); }

 private:
  std::map<Point3, std::uint32_t> index_;
  std::vector<Point3> points_;
};

/// One triangle, projected along the axis nearest to its normal.
class TriangleCut {
 public:
  TriangleCut(const Point3& a, const Point3& b, const Point3& c) : corner_{a, b, c} {
    normal_ = CGAL::cross_product(b - a, c - a);
    for (int axis = 0; axis < 3; ++axis)
      if (CGAL::abs(normal_[axis]) > CGAL::abs(normal_[axis_])) axis_ = axis;
    std::array<Plane::Vertex_handle, 3> v;
    for (std::size_t k = 0; k < 3; ++k) v[k] = plane_.insert(seen(corner_[k]));
    for (std::size_t k = 0; k < 3; ++k) plane_.insert_constraint(v[k], v[(k + 1) % 3]);
  }

  void add(const Point3& p) { plane_.insert(seen(p)); }
  void add(const Point3& p, const Point3& q) {
    if (p != q)
      plane_.insert_constraint(seen(p), seen(q));
    else
      add(p);
  }

  /// The pieces, wound like the triangle.
  template <class Add>
  void pieces(ExactPoints& points, Add add) {
    for (auto v = plane_.finite_vertices_begin(); v != plane_.finite_vertices_end(); ++v) v->info() = points.indexOf(lifted(v->point()));
    settleTies();
    const bool is_turned = CGAL::orientation(seen(corner_[0]), seen(corner_[1]), seen(corner_[2])) == CGAL::RIGHT_TURN;
    for (auto f = plane_.finite_faces_begin(); f != plane_.finite_faces_end(); ++f) {
      Triangle piece{f->vertex(0)->info(), f->vertex(1)->info(), f->vertex(2)->info()};
      if (is_turned) std::swap(piece[1], piece[2]);
      add(piece);
    }
  }

 private:
  Point2 seen(const Point3& p) const { return Point2(p[(axis_ + 1) % 3], p[(axis_ + 2) % 3]); }
  Point3 lifted(const Point2& p) const {
    std::array<Exact::FT, 3> q;
    const int u = (axis_ + 1) % 3, v = (axis_ + 2) % 3;
    q[static_cast<std::size_t>(u)] = p.x(), q[static_cast<std::size_t>(v)] = p.y();
    q[static_cast<std::size_t>(axis_)] =
        corner_[0][axis_] - (normal_[u] * (p.x() - corner_[0][u]) + normal_[v] * (p.y() - corner_[0][v])) / normal_[axis_];
    return {q[0], q[1], q[2]};
  }

  // Four points on a circle have two Delaunay triangulations. Two coplanar triangles must be cut in the same way;
  // therefore the diagonal is flipped to the lexicographically lowest point. Each flip gives that point one more edge,
  // so this ends.
  void settleTies() {
    for (bool again = true; again;) {
      again = false;
      for (auto e = plane_.finite_edges_begin(); e != plane_.finite_edges_end(); ++e) {
        const auto f = e->first;
        const int i = e->second;
        const auto g = f->neighbor(i);
        if (f->is_constrained(i) || plane_.is_infinite(f) || plane_.is_infinite(g)) continue;
        const auto a = f->vertex(i), b = f->vertex(Plane::ccw(i)), c = g->vertex(g->index(f)), d = f->vertex(Plane::cw(i));
        const Point2& lowest = std::min({a->point(), b->point(), c->point(), d->point()});
        if (lowest == b->point() || lowest == d->point()) continue;
        if (CGAL::side_of_oriented_circle(a->point(), b->point(), d->point(), c->point()) != CGAL::ON_ORIENTED_BOUNDARY) continue;
        plane_.tds().flip(f, i);
        again = true;
        break;
      }
    }
  }

  std::array<Point3, 3> corner_;
  Exact::Vector_3 normal_;
  int axis_ = 0;
  Plane plane_;
};

/// A mesh whose triangles meet only in corners and edges. Triangles with the same corners count as one.
struct Arrangement {
  struct Member {
    std::uint32_t triangle;  // of the soup
    int winding;             // +1: like the facet, -1: opposite
  };
  std::vector<Triangle> facets;
  std::vector<std::vector<Member>> members;
  std::vector<Vector3d> positions;

  double area(std::size_t f) const {
    const auto& [a, b, c] = facets[f];
    return 0.5 * (positions[b] - positions[a]).cross(positions[c] - positions[a]).norm();
  }
};

Arrangement arrange(const TriangleMesh& mesh, const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs, Progress& progress) {
  std::vector<Point3> exact;
  exact.reserve(mesh.positions.size());
  for (const Vector3d& p : mesh.positions) exact.emplace_back(p.x(), p.y(), p.z());
  std::map<std::uint32_t, TriangleCut> cuts;
  const auto cutOf = [&](std::uint32_t t) -> TriangleCut& {
    const auto [a, b, c] = mesh.triangles[t];
    return cuts.try_emplace(t, exact[a], exact[b], exact[c]).first->second;
  };
  const auto triangleOf = [&](std::uint32_t t) {
    const auto [a, b, c] = mesh.triangles[t];
    return Exact::Triangle_3(exact[a], exact[b], exact[c]);
  };
  std::size_t done = 0;
  for (const auto& [t, u] : pairs) {
    if (++done % 256 == 0) progress.check(), progress.advance(0.7 * static_cast<double>(done) / static_cast<double>(pairs.size()));
    const auto common = CGAL::intersection(triangleOf(t), triangleOf(u));
    if (!common) continue;
    for (TriangleCut* cut : {&cutOf(t), &cutOf(u)}) {
      if (const Point3* p = boost::get<Point3>(&*common)) {
        cut->add(*p);
      } else if (const Exact::Segment_3* s = boost::get<Exact::Segment_3>(&*common)) {
        cut->add(s->source(), s->target());
      } else if (const Exact::Triangle_3* f = boost::get<Exact::Triangle_3>(&*common)) {
        for (int k = 0; k < 3; ++k) cut->add(f->vertex(k), f->vertex(k + 1));
      } else if (const std::vector<Point3>* polygon = boost::get<std::vector<Point3>>(&*common)) {
        for (std::size_t k = 0; k < polygon->size(); ++k) cut->add((*polygon)[k], (*polygon)[(k + 1) % polygon->size()]);
      }
    }
  }
  Arrangement result;
  ExactPoints points;
  std::vector<std::uint32_t> index(exact.size());
  for (std::size_t v = 0; v < exact.size(); ++v) index[v] = points.indexOf(exact[v]);
  std::map<Triangle, std::size_t> facet_of;
  const auto add = [&](const Triangle& piece, std::uint32_t t) {
    Triangle key = piece;
    std::sort(key.begin(), key.end());
    const auto [at, is_new] = facet_of.try_emplace(key, result.facets.size());
    if (is_new) result.facets.push_back(piece), result.members.emplace_back();
    Triangle first = result.facets[at->second];
    std::rotate(first.begin(), std::ranges::find(first, piece[0]), first.end());
    result.members[at->second].push_back({t, first == piece ? 1 : -1});
  };
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (const auto cut = cuts.find(t); cut != cuts.end()) {
      cut->second.pieces(points, [&](const Triangle& piece) { add(piece, t); });
    } else {
      const auto [a, b, c] = mesh.triangles[t];
      add({index[a], index[b], index[c]}, t);
    }
    if (t % 256 == 0) progress.check();
  }
  result.positions.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    result.positions.emplace_back(CGAL::to_double(points[i].x()), CGAL::to_double(points[i].y()), CGAL::to_double(points[i].z()));
  return result;
}

/// Facets that are connected by edges of exactly two facets have the same winding numbers on their sides, after they
/// are wound consistently; the numbers are computed once for each such patch.
class Classifier {
 public:
  explicit Classifier(const Arrangement& a) : a_(a), mesh_{a.positions, a.facets, {}, {}}, patch_(a.facets.size(), kNone) { findPatches(); }

  /// Winding number on the front of every facet.
  std::vector<int> fronts() {
    // The original surface, since a facet of several triangles counts several times.
    TriangleMesh whole{a_.positions, {}, {}, {}};
    std::vector<std::vector<std::uint32_t>> of_facet(a_.facets.size());
    for (std::size_t f = 0; f < a_.facets.size(); ++f) {
      int net = 0;
      for (const Arrangement::Member& m : a_.members[f]) net += m.winding;
      for (int i = 0; i < std::abs(net); ++i) {
        of_facet[f].push_back(static_cast<std::uint32_t>(whole.triangles.size()));
        Triangle triangle = a_.facets[f];
        if (net < 0) std::swap(triangle[1], triangle[2]);
        whole.triangles.push_back(triangle);
      }
    }
    const WindingNumber winding(whole);
    // The largest facet of each patch is used.
    std::vector<std::uint32_t> largest(patches_, kNone);
    std::vector<double> area(patches_, -1);
    for (std::uint32_t f = 0; f < a_.facets.size(); ++f) {
      const double own = a_.area(f);
      if (own > area[patch_[f]]) area[patch_[f]] = own, largest[patch_[f]] = f;
    }
    std::vector<int> front_of_patch(patches_);  // on the front of the largest facet
    for (std::size_t p = 0; p < patches_; ++p) {
      const std::uint32_t f = largest[p];
      const Vector3d middle = (mesh_.corner(f, 0) + mesh_.corner(f, 1) + mesh_.corner(f, 2)) / 3;
      front_of_patch[p] = static_cast<int>(std::lround(winding.at(middle, of_facet[f]) - 0.5 * net(f)));
    }
    std::vector<int> fronts(a_.facets.size());
    for (std::uint32_t f = 0; f < a_.facets.size(); ++f) {
      const std::uint32_t speaker = largest[patch_[f]];
      const bool is_alike = alike_[f] == alike_[speaker];
      fronts[f] = is_alike ? front_of_patch[patch_[f]] : front_of_patch[patch_[f]] + net(speaker);
    }
    return fronts;
  }

  /// Difference of the winding numbers behind and in front of a facet.
  int net(std::size_t f) const {
    int sum = 0;
    for (const Arrangement::Member& m : a_.members[f]) sum += m.winding;
    return sum;
  }

 private:
  void findPatches() {
    struct FacetSide {
      std::uint64_t edge;
      std::uint32_t facet;
      bool forward;
    };
    std::vector<FacetSide> sides;
    for (std::uint32_t f = 0; f < a_.facets.size(); ++f)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t u = a_.facets[f][k], v = a_.facets[f][(k + 1) % 3];
        sides.push_back({std::uint64_t{std::min(u, v)} << 32 | std::max(u, v), f, u < v});
      }
    std::sort(sides.begin(), sides.end(),
              [](const FacetSide& a, const FacetSide& b) { return std::tie(a.edge, a.facet) < std::tie(b.edge, b.facet); });
    struct Neighbour {
      std::uint32_t facet;
      bool is_alike;
    };
    std::vector<std::vector<Neighbour>> neighbours(a_.facets.size());
    for (std::size_t i = 0, j = 0; i < sides.size(); i = j) {
      while (j < sides.size() && sides[j].edge == sides[i].edge) ++j;
      if (j - i != 2) continue;
      const bool is_alike = sides[i].forward != sides[i + 1].forward;
      if (net(sides[i].facet) != (is_alike ? 1 : -1) * net(sides[i + 1].facet)) continue;  // not closed there
      neighbours[sides[i].facet].push_back({sides[i + 1].facet, is_alike});
      neighbours[sides[i + 1].facet].push_back({sides[i].facet, is_alike});
    }
    alike_.assign(a_.facets.size(), 1);
    std::vector<std::uint32_t> queue;
    for (std::uint32_t seed = 0; seed < a_.facets.size(); ++seed) {
      if (patch_[seed] != kNone) continue;
      patch_[seed] = static_cast<std::uint32_t>(patches_);
      queue.assign(1, seed);
      while (!queue.empty()) {
        const std::uint32_t f = queue.back();
        queue.pop_back();
        for (const Neighbour& n : neighbours[f])
          if (patch_[n.facet] == kNone) {
            patch_[n.facet] = patch_[seed];
            alike_[n.facet] = static_cast<char>(n.is_alike ? alike_[f] : !alike_[f]);
            queue.push_back(n.facet);
          }
      }
      ++patches_;
    }
  }

  const Arrangement& a_;
  TriangleMesh mesh_;
  std::vector<std::uint32_t> patch_;
  std::vector<char> alike_;  // whether it is wound like the first facet of its patch
  std::size_t patches_ = 0;
};

std::vector<std::uint32_t> sorted(std::vector<std::uint32_t> list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
  return list;
}

}  // namespace

Resolved resolveOverlaps(RepairSoup& soup, std::size_t max_pairs, double max_lost, Progress& progress) {
  Resolved result;
  const CrossingTriangles crossing = findCrossingTriangles(soup.mesh, max_pairs);
  result.crossing_pairs = crossing.pairs.size();
  result.is_stopped = crossing.is_stopped;
  if (crossing.is_stopped) return result;
  const Arrangement arrangement = arrange(soup.mesh, crossing.pairs, progress);
  progress.check();
  Classifier classifier(arrangement);
  const std::vector<int> fronts = classifier.fronts();

  const auto isSolid = [&](int winding) { return winding >= 1 || (result.is_either_way && winding < 0); };
  const auto boundsNothing = [&](std::size_t f) { return !isSolid(fronts[f]) && !isSolid(fronts[f] + classifier.net(f)); };
  const auto lostArea = [&] {
    double sum = 0;
    for (std::size_t f = 0; f < arrangement.facets.size(); ++f)
      if (boundsNothing(f) &&
          std::ranges::any_of(arrangement.members[f], [&](const auto& m) { return soup.source[m.triangle] != kAddedTriangle; }))
        sum += arrangement.area(f);
    return sum;
  };
  result.lost_area = lostArea();
  if (result.lost_area > max_lost) {
    result.is_either_way = true;
    result.lost_area = lostArea();
  }

  RepairSoup kept;
  kept.mesh.positions = arrangement.positions;
  std::vector<std::uint32_t> within, bounds;
  for (std::size_t f = 0; f < arrangement.facets.size(); ++f) {
    const bool front = isSolid(fronts[f]), back = isSolid(fronts[f] + classifier.net(f));
    std::uint32_t speaker = kAddedTriangle;  // the first triangle of the input
    for (const Arrangement::Member& m : arrangement.members[f]) {
      const std::uint32_t source = soup.source[m.triangle];
      if (source == kAddedTriangle) continue;
      speaker = std::min(speaker, source);
      (front != back ? bounds : front ? within : result.lost).push_back(source);
    }
    if (front == back) continue;
    Triangle corners = arrangement.facets[f];
    if (front) std::swap(corners[1], corners[2]);
    kept.mesh.triangles.push_back(corners);
    kept.source.push_back(speaker);
  }
  within = sorted(within), bounds = sorted(bounds), result.lost = sorted(result.lost);
  for (const std::uint32_t source : within) {
    const bool is_left =
        std::binary_search(bounds.begin(), bounds.end(), source) || std::binary_search(result.lost.begin(), result.lost.end(), source);
    (is_left ? result.partly_within : result.within).push_back(source);
  }
  dropUnusedVertices(kept.mesh);
  soup = std::move(kept);
  return result;
}

}  // namespace spheretree::builder
