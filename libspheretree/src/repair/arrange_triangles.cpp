// SPDX-License-Identifier: GPL-3.0-or-later
#include "repair/arrange_triangles.h"

#include <CGAL/Box_intersection_d/Box_with_info_d.h>
#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/box_intersection_d.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "repair/cut_points.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

using Exact = CutPoints::Exact;
using Point2 = Exact::Point_2;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, Exact>;
using FaceBase = CGAL::Constrained_triangulation_face_base_2<Exact>;
using Plane = CGAL::Constrained_Delaunay_triangulation_2<Exact, CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>,
                                                         CGAL::No_constraint_intersection_requiring_constructions_tag>;

// Pairs of cuts that may cross for each point that there may be. Where k cuts meet in one point, there are k^2 / 2.
constexpr std::size_t kCrossingsOfPoint = 8;

/// The cuts of all triangles: those of one triangle are consecutive.
struct Cuts {
  std::vector<std::uint32_t> triangles;  // that are cut, ascending
  std::vector<std::size_t> first;        // for each of them: index in `cuts`; then their number
  std::vector<TriangleCut> cuts;
};

/// One triangle with its cuts, projected along an axis.
class DividedTriangle {
 public:
  DividedTriangle(const TriangleMesh& mesh, std::uint32_t t, std::span<const TriangleCut> cuts, CutPoints& points, RepairWork& work)
      : points_(points), work_(work), t_(t), axis_(projectionAxis(mesh, t)) {
    for (const std::uint32_t v : mesh.triangles[t]) corner_.push_back(points.ofVertex(v));
    ids_ = corner_;
    for (const TriangleCut& cut : cuts) {
      ids_.push_back(cut.from), ids_.push_back(cut.to);
      if (cut.from != cut.to) cuts_.push_back({std::min(cut.from, cut.to), std::max(cut.from, cut.to), cut.carrier});
    }
    const auto ends = [](const TriangleCut& cut) { return std::pair(cut.from, cut.to); };
    std::ranges::stable_sort(cuts_, {}, ends);
    cuts_.erase(std::unique(cuts_.begin(), cuts_.end(), [&](const TriangleCut& a, const TriangleCut& b) { return ends(a) == ends(b); }),
                cuts_.end());
  }

  /// Finds the points where two cuts cross. Returns false if there are more than `max_points` in all.
  bool findCrossings(std::size_t max_points);
  std::size_t pointCount() const { return ids_.size(); }

  /// Calls `add` with the pieces, wound like the triangle.
  template <class Add>
  void divide(Add add);

 private:
  using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 2, std::uint32_t>;
  Point2 seen(std::uint32_t id) const {
    const Exact::Point_3& p = points_[id];
    return Point2(p[(axis_ + 1) % 3], p[(axis_ + 2) % 3]);
  }
  const Point2& at(std::uint32_t id) const {
    return place_[static_cast<std::size_t>(std::lower_bound(ids_.begin(), ids_.end(), id) - ids_.begin())];
  }
  void sortPoints() {
    std::sort(ids_.begin(), ids_.end());
    ids_.erase(std::unique(ids_.begin(), ids_.end()), ids_.end());
    place_.clear();
    for (const std::uint32_t id : ids_) place_.push_back(seen(id));
  }
  Box boxOf(std::uint32_t cut) const;
  bool doCross(const TriangleCut& a, const TriangleCut& b) const;
  void settleTies();

  std::vector<TriangleCut> cuts_;  // segments, each once
  CutPoints& points_;
  RepairWork& work_;
  std::uint32_t t_;
  int axis_;
  std::vector<std::uint32_t> corner_, ids_;  // points: of the corners; all, ascending after sortPoints()
  std::vector<Point2> place_;                // for each of ids_
  Plane plane_;
};

DividedTriangle::Box DividedTriangle::boxOf(std::uint32_t cut) const {
  CGAL::Bbox_2 box = at(cuts_[cut].from).bbox() + at(cuts_[cut].to).bbox();
  return {box, cut};
}

/// Whether two cuts cross within both.
bool DividedTriangle::doCross(const TriangleCut& a, const TriangleCut& b) const {
  if (a.from == b.from || a.from == b.to || a.to == b.from || a.to == b.to) return false;
  const Point2 &p = at(a.from), &q = at(a.to), &r = at(b.from), &s = at(b.to);
  const auto side = CGAL::orientation(p, q, r);
  if (side == CGAL::COLLINEAR || CGAL::orientation(p, q, s) != -side) return false;
  const auto other = CGAL::orientation(r, s, p);
  return other != CGAL::COLLINEAR && CGAL::orientation(r, s, q) == -other;
}

bool DividedTriangle::findCrossings(std::size_t max_points) {
  sortPoints();
  if (ids_.size() > max_points) return false;
  std::vector<Box> boxes;
  for (std::uint32_t i = 0; i < cuts_.size(); ++i) boxes.push_back(boxOf(i));
  std::vector<std::pair<std::uint32_t, std::uint32_t>> crossing;
  struct TooMany {};
  try {
    CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const Box& a, const Box& b) {
      work_.spend(1);
      if (!doCross(cuts_[a.info()], cuts_[b.info()])) return;
      if (crossing.size() > kCrossingsOfPoint * max_points) throw TooMany{};
      crossing.push_back(std::minmax(a.info(), b.info()));
    });
  } catch (const TooMany&) {
    return false;
  }
  std::sort(crossing.begin(), crossing.end());
  std::vector<std::uint32_t> found;
  for (const auto& [i, j] : crossing) {
    work_.spend(kConstruction);
    found.push_back(points_.crossing(t_, cuts_[i].carrier, cuts_[j].carrier));
    if (found.size() % 1024 != 0 && found.size() != crossing.size()) continue;
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    if (ids_.size() + found.size() > max_points + corner_.size()) return false;
  }
  ids_.insert(ids_.end(), found.begin(), found.end());
  sortPoints();
  return ids_.size() <= max_points;
}

template <class Add>
void DividedTriangle::divide(Add add) {
  std::vector<Plane::Vertex_handle> handle(ids_.size());
  const auto handleOf = [&](std::uint32_t id) -> Plane::Vertex_handle& {
    return handle[static_cast<std::size_t>(std::lower_bound(ids_.begin(), ids_.end(), id) - ids_.begin())];
  };
  for (const std::uint32_t id : corner_) handleOf(id) = plane_.insert(at(id));
  Plane::Face_handle near;
  for (const std::uint32_t id : ids_) {
    work_.spend(kConstruction);
    Plane::Vertex_handle& v = handleOf(id);
    if (v == Plane::Vertex_handle()) v = plane_.insert(at(id), near), near = v->face();
    v->info() = id;
  }
  for (std::size_t k = 0; k < 3; ++k) plane_.insert_constraint(handleOf(corner_[k]), handleOf(corner_[(k + 1) % 3]));
  for (const TriangleCut& cut : cuts_) {
    work_.spend(kConstruction);
    plane_.insert_constraint(handleOf(cut.from), handleOf(cut.to));
  }
  settleTies();
  const bool is_turned = CGAL::orientation(at(corner_[0]), at(corner_[1]), at(corner_[2])) == CGAL::RIGHT_TURN;
  for (auto f = plane_.finite_faces_begin(); f != plane_.finite_faces_end(); ++f) {
    Triangle piece{f->vertex(0)->info(), f->vertex(1)->info(), f->vertex(2)->info()};
    if (is_turned) std::swap(piece[1], piece[2]);
    add(piece);
  }
}

// Four points on a circle have two Delaunay triangulations. Two coplanar triangles must be cut in the same way;
// therefore the diagonal is flipped to the lexicographically lowest point. Each flip gives that point one more edge, so
// this ends.
void DividedTriangle::settleTies() {
  for (bool again = true; again;) {
    again = false;
    for (auto f = plane_.finite_faces_begin(); f != plane_.finite_faces_end(); ++f) {
      work_.spend(1);
      for (int i = 0; i < 3; ++i) {
        const auto g = f->neighbor(i);
        if (f->is_constrained(i) || plane_.is_infinite(g)) continue;
        const auto a = f->vertex(i), b = f->vertex(Plane::ccw(i)), c = g->vertex(g->index(f)), d = f->vertex(Plane::cw(i));
        if (CGAL::side_of_oriented_circle(a->point(), b->point(), d->point(), c->point()) != CGAL::ON_ORIENTED_BOUNDARY) continue;
        const Point2& lowest = std::min({a->point(), b->point(), c->point(), d->point()});
        if (lowest == b->point() || lowest == d->point()) continue;
        plane_.tds().flip(f, i);
        again = true;
      }
    }
  }
}

/// Where the triangles of each pair cut each other.
Cuts findCuts(const TriangleMesh& mesh, std::span<const std::pair<std::uint32_t, std::uint32_t>> pairs, CutPoints& points,
              Progress& progress, RepairWork& work) {
  Cuts result;
  for (const auto& [t, u] : pairs) result.triangles.push_back(t), result.triangles.push_back(u);
  std::sort(result.triangles.begin(), result.triangles.end());
  result.triangles.erase(std::unique(result.triangles.begin(), result.triangles.end()), result.triangles.end());
  for (const std::uint32_t t : result.triangles)
    for (const std::uint32_t v : mesh.triangles[t]) points.ofVertex(v);  // in ascending order: the first vertex names the place
  std::vector<std::pair<std::uint32_t, TriangleCut>> all;
  std::vector<TriangleCut> first, second;
  std::size_t done = 0;
  for (const auto& [t, u] : pairs) {
    work.spend(kConstruction);
    if (++done % 256 == 0) progress.advance(0.3 * static_cast<double>(done) / static_cast<double>(pairs.size()));
    first.clear(), second.clear();
    points.cut(t, u, first, second);
    for (const TriangleCut& cut : first) all.emplace_back(t, cut);
    for (const TriangleCut& cut : second) all.emplace_back(u, cut);
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (std::size_t i = 0; const std::uint32_t t : result.triangles) {
    result.first.push_back(i);
    for (; i < all.size() && all[i].first == t; ++i) result.cuts.push_back(all[i].second);
  }
  result.first.push_back(result.cuts.size());
  return result;
}

/// Triangles with the same corners become one facet with several members.
Arrangement joinPieces(const std::vector<std::pair<Triangle, std::uint32_t>>& pieces) {
  Arrangement result;
  std::vector<std::pair<Triangle, std::uint32_t>> sorted;  // corners in order, then the piece
  sorted.reserve(pieces.size());
  for (std::uint32_t i = 0; i < pieces.size(); ++i) {
    sorted.emplace_back(pieces[i].first, i);
    std::sort(sorted.back().first.begin(), sorted.back().first.end());
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<std::uint32_t> speaker(pieces.size()), next(pieces.size(), 0);  // of each piece: the first one with its corners; the next one
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const bool is_same = i > 0 && sorted[i].first == sorted[i - 1].first;
    speaker[sorted[i].second] = is_same ? speaker[sorted[i - 1].second] : sorted[i].second;
    if (is_same) next[sorted[i - 1].second] = sorted[i].second;
  }
  for (std::uint32_t i = 0; i < pieces.size(); ++i) {
    if (speaker[i] != i) continue;
    const Triangle& facet = pieces[i].first;
    result.facets.push_back(facet);
    result.first_member.push_back(static_cast<std::uint32_t>(result.members.size()));
    for (std::uint32_t j = i; result.members.size() == result.first_member.back() || j != 0; j = next[j]) {
      Triangle piece = pieces[j].first;
      std::rotate(piece.begin(), std::ranges::find(piece, facet[0]), piece.end());
      result.members.push_back({pieces[j].second, piece == facet ? 1 : -1});
    }
  }
  result.first_member.push_back(static_cast<std::uint32_t>(result.members.size()));
  return result;
}

}  // namespace

int Arrangement::net(std::size_t f) const {
  int sum = 0;
  for (const Member& m : membersOf(f)) sum += m.winding;
  return sum;
}

double Arrangement::area(std::size_t f) const {
  const auto& [a, b, c] = facets[f];
  return 0.5 * (positions[b] - positions[a]).cross(positions[c] - positions[a]).norm();
}

std::optional<Arrangement> arrangeTriangles(const TriangleMesh& mesh, std::span<const std::pair<std::uint32_t, std::uint32_t>> pairs,
                                            std::size_t max_pieces, Progress& progress, RepairWork& work) {
  CutPoints points(mesh);
  const Cuts cuts = findCuts(mesh, pairs, points, progress, work);
  std::vector<std::pair<Triangle, std::uint32_t>> pieces;  // with the triangle of each
  std::size_t bound = mesh.triangles.size();               // of the number of pieces: of those to come, one for each triangle
  for (std::uint32_t t = 0, i = 0; t < mesh.triangles.size(); ++t) {
    if (t % 256 == 0) progress.check(), progress.advance(0.3 + 0.6 * t / static_cast<double>(mesh.triangles.size()));
    if (i == cuts.triangles.size() || cuts.triangles[i] != t) {
      pieces.emplace_back(mesh.triangles[t], t);
      continue;
    }
    const std::span<const TriangleCut> own(cuts.cuts.data() + cuts.first[i], cuts.cuts.data() + cuts.first[i + 1]);
    ++i;
    DividedTriangle divided(mesh, t, own, points, work);
    const std::size_t left = max_pieces > bound ? max_pieces - bound : 0;  // beside one piece for each triangle
    if (!divided.findCrossings(3 + left / 2)) return std::nullopt;
    const std::size_t before = pieces.size();
    divided.divide([&](const Triangle& piece) { pieces.emplace_back(piece, t); });
    bound += pieces.size() - before - 1;
  }
  Arrangement result = joinPieces(pieces);
  progress.check();
  result.positions = points.rounded();
  return result;
}

}  // namespace spheretree::builder
