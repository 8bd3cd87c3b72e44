// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/mesh_checks.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "spheretree/builder/box_tree.h"
#include "spheretree/builder/crossing_triangles.h"

namespace spheretree::builder {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;

// Radii reach down to 1e-3 of the diagonal and are squared in float32, which holds 1e-38 to 3e38.
constexpr double kSmallestDiagonal = 1e-9, kLargestDiagonal = 1e12;  // [mm]
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

class Groups {  // union-find; the root of a group is its lowest member
 public:
  explicit Groups(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0u); }
  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = root(a), b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

struct Side {          // one triangle at one edge
  std::uint64_t edge;  // lower vertex << 32 | higher vertex
  std::uint32_t triangle;
  std::uint8_t corner;  // the edge runs from this corner to the next
  bool forward;         // from the lower to the higher vertex

  std::uint32_t low() const { return static_cast<std::uint32_t>(edge >> 32); }
  std::uint32_t high() const { return static_cast<std::uint32_t>(edge); }
};

class MeshCheck {
 public:
  explicit MeshCheck(const TriangleMesh& mesh) : mesh_(mesh) {}

  MeshReport run() {
    report_.triangles = mesh_.triangles.size();
    report_.vertices = mesh_.positions.size();
    if (mesh_.triangles.empty()) {
      defect(DefectKind::NoTriangles).count = 1;
      return finish();
    }
    findBadNumbers();
    if (!report_.defects.empty()) {
      report_.not_checked.push_back("Nothing else was checked: the triangles are not all there.");
      return finish();
    }
    measure();
    findDegenerateFaces();
    findDuplicateFaces();
    sortSides();
    findEdgeDefects();
    findNonManifoldVertices();
    nameComponents();
    if (report_.has(DefectKind::Scale)) {
      report_.not_checked.push_back("Volumes and self-intersections were not checked: first put the unit right.");
      return finish();
    }
    findCrossings();
    findOrientation();
    return finish();
  }

 private:
  Defect& defect(DefectKind kind) {
    for (Defect& d : report_.defects)
      if (d.kind == kind) return d;
    report_.defects.push_back(Defect{kind, 0, false, {}});
    return report_.defects.back();
  }

  void add(DefectKind kind, Place place) {
    Defect& d = defect(kind);
    ++d.count;
    if (d.first.size() < kPlacesListed) d.first.push_back(std::move(place));
  }

  MeshReport finish() {
    std::stable_sort(report_.defects.begin(), report_.defects.end(), [](const Defect& a, const Defect& b) { return a.kind < b.kind; });
    return std::move(report_);
  }

  Place triangleAt(std::uint32_t t) const { return {{t}, {}, mesh_.corner(t, 0) / 3 + mesh_.corner(t, 1) / 3 + mesh_.corner(t, 2) / 3}; }
  Place edgeAt(const Side& side) const {
    return {{side.triangle}, {side.low(), side.high()}, mesh_.positions[side.low()] / 2 + mesh_.positions[side.high()] / 2};
  }

  // --- numbers ---

  void findBadNumbers() {
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      for (const std::uint32_t v : mesh_.triangles[t]) {
        if (v >= mesh_.positions.size()) {
          add(DefectKind::BadIndex, {{t}, {v}, Eigen::Vector3d::Zero()});
          break;
        }
        if (!mesh_.positions[v].allFinite()) {
          add(DefectKind::NonFinite, {{t}, {v}, mesh_.positions[v]});
          break;
        }
      }
    }
  }

  void measure() {
    report_.low.setConstant(std::numeric_limits<double>::infinity());
    report_.high = -report_.low;
    for (const Triangle& triangle : mesh_.triangles)
      for (const std::uint32_t v : triangle) {
        report_.low = report_.low.cwiseMin(mesh_.positions[v]);
        report_.high = report_.high.cwiseMax(mesh_.positions[v]);
      }
    largest_coordinate_ = std::max(report_.low.cwiseAbs().maxCoeff(), report_.high.cwiseAbs().maxCoeff());
    centre_ = report_.low / 2 + report_.high / 2;
    // Halved before the difference, as the box of huge coordinates would overflow.
    scale_ = (report_.high / 2 - report_.low / 2).stableNorm();
    const double diagonal = 2 * scale_;
    if (!(diagonal >= kSmallestDiagonal && diagonal <= kLargestDiagonal)) {
      add(DefectKind::Scale, {{}, {}, centre_});
      return;
    }
    double volume = 0, area = 0;
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) volume += unitVolume(t), area += unitArea(t);
    report_.volume = volume * scale_ * scale_ * scale_;
    report_.area = area * scale_ * scale_;
  }

  /// About the centre of the box, in units of half its diagonal: far from the origin the terms would cancel.
  Eigen::Vector3d unitCorner(std::uint32_t t, int k) const { return (mesh_.corner(t, k) - centre_) / scale_; }
  double unitVolume(std::uint32_t t) const {
    const Eigen::Vector3d a = unitCorner(t, 0), b = unitCorner(t, 1), c = unitCorner(t, 2);
    return a.dot((b - a).cross(c - a)) / 6;  // differences first: small triangles keep their digits
  }
  double unitArea(std::uint32_t t) const {
    const Eigen::Vector3d a = unitCorner(t, 0), b = unitCorner(t, 1), c = unitCorner(t, 2);
    return (b - a).cross(c - a).norm() / 2;
  }

  // --- single triangles ---

  void findDegenerateFaces() {
    points_.reserve(mesh_.positions.size());
    for (const Eigen::Vector3d& p : mesh_.positions) points_.emplace_back(p.x(), p.y(), p.z());
    has_edges_.resize(mesh_.triangles.size());
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      const auto [a, b, c] = mesh_.triangles[t];
      has_edges_[t] = a != b && b != c && c != a;
      if (isFlat(mesh_, t)) add(DefectKind::DegenerateFace, triangleAt(t));
    }
  }

  void findDuplicateFaces() {
    std::vector<std::pair<Triangle, std::uint32_t>> sorted;  // corners in order, then the triangle
    sorted.reserve(mesh_.triangles.size());
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (!has_edges_[t]) continue;
      Triangle triangle = mesh_.triangles[t];
      std::sort(triangle.begin(), triangle.end());
      sorted.emplace_back(triangle, t);
    }
    std::sort(sorted.begin(), sorted.end());
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;  // the later triangle, the first with these corners
    std::uint32_t first = 0;
    for (std::size_t i = 0; i < sorted.size(); ++i) {
      if (i == 0 || sorted[i].first != sorted[i - 1].first)
        first = sorted[i].second;
      else
        pairs.emplace_back(sorted[i].second, first);
    }
    std::sort(pairs.begin(), pairs.end());
    for (const auto& [later, earlier] : pairs) {
      Place place = triangleAt(later);
      place.triangles.push_back(earlier);
      add(DefectKind::DuplicateFace, std::move(place));
    }
  }

  // --- edges and vertices ---

  void sortSides() {
    sides_.reserve(mesh_.triangles.size() * 3);
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (!has_edges_[t]) continue;
      for (std::uint8_t k = 0; k < 3; ++k) {
        const std::uint32_t a = mesh_.triangles[t][k], b = mesh_.triangles[t][(k + 1) % 3];
        sides_.push_back({std::uint64_t{std::min(a, b)} << 32 | std::max(a, b), t, k, a < b});
      }
    }
    std::sort(sides_.begin(), sides_.end(),
              [](const Side& a, const Side& b) { return std::tie(a.edge, a.triangle) < std::tie(b.edge, b.triangle); });
  }

  /// Calls `visit(first, last)` with the sides of each edge.
  template <class Visit>
  void forEachEdge(Visit&& visit) const {
    for (std::size_t first = 0, last = 0; first < sides_.size(); first = last) {
      while (last < sides_.size() && sides_[last].edge == sides_[first].edge) ++last;
      visit(first, last);
    }
  }

  void findEdgeDefects() {
    std::array<std::vector<std::size_t>, 3> found;  // first sides: of one triangle, of two that clash, of three or more
    forEachEdge([&](std::size_t first, std::size_t last) {
      if (last - first == 1) found[0].push_back(first);
      if (last - first == 2 && sides_[first].forward == sides_[first + 1].forward) found[1].push_back(first);
      if (last - first > 2) found[2].push_back(first);
    });
    static constexpr DefectKind kKinds[] = {DefectKind::Border, DefectKind::ClashingWinding, DefectKind::NonManifoldEdge};
    for (std::size_t k = 0; k < 3; ++k) {
      std::sort(found[k].begin(), found[k].end(), [&](std::size_t a, std::size_t b) { return bySide(sides_[a], sides_[b]); });
      for (const std::size_t i : found[k]) {
        Place place = edgeAt(sides_[i]);
        if (k > 0) place.triangles.push_back(sides_[i + 1].triangle);
        add(kKinds[k], std::move(place));
      }
    }
    is_closed_ = found[0].empty() && found[1].empty() && found[2].empty();
    findHoles(found[0]);
  }

  static bool bySide(const Side& a, const Side& b) { return std::tie(a.triangle, a.corner) < std::tie(b.triangle, b.corner); }

  void findHoles(const std::vector<std::size_t>& border) {
    if (border.empty()) return;
    Groups groups(mesh_.positions.size());
    for (const std::size_t i : border) groups.join(sides_[i].low(), sides_[i].high());
    std::map<std::uint32_t, Hole> holes;
    for (const std::size_t i : border) {  // in the order of the mesh
      Hole& hole = holes[groups.root(sides_[i].low())];
      if (hole.edges++ == 0) hole.first = edgeAt(sides_[i]);
      hole.length += (mesh_.positions[sides_[i].high()] / 2 - mesh_.positions[sides_[i].low()] / 2).stableNorm() * 2;
    }
    for (auto& [root, hole] : holes) report_.holes.push_back(std::move(hole));
    std::stable_sort(report_.holes.begin(), report_.holes.end(), [](const Hole& a, const Hole& b) { return a.length > b.length; });
  }

  void findNonManifoldVertices() {
    // Corners of one vertex hang together if their triangles share an edge at it.
    Groups corners(mesh_.triangles.size() * 3);
    const auto cornerAt = [&](const Side& side, std::uint32_t vertex) {
      const std::uint32_t k = mesh_.triangles[side.triangle][side.corner] == vertex ? side.corner : (side.corner + 1u) % 3u;
      return side.triangle * 3 + k;
    };
    forEachEdge([&](std::size_t first, std::size_t last) {
      for (std::size_t i = first + 1; i < last; ++i)
        for (const std::uint32_t vertex : {sides_[first].low(), sides_[first].high()})
          corners.join(cornerAt(sides_[first], vertex), cornerAt(sides_[i], vertex));
    });
    std::vector<std::uint32_t> fan(mesh_.positions.size(), kNone);  // of the first corner; then kDone
    constexpr std::uint32_t kDone = kNone - 1;
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (!has_edges_[t]) continue;
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t vertex = mesh_.triangles[t][k], root = corners.root(t * 3 + k);
        if (fan[vertex] == kNone) fan[vertex] = root;
        if (fan[vertex] == root || fan[vertex] == kDone) continue;
        add(DefectKind::NonManifoldVertex, {{fan[vertex] / 3, t}, {vertex}, mesh_.positions[vertex]});
        fan[vertex] = kDone;
      }
    }
  }

  void nameComponents() {
    Groups groups(mesh_.triangles.size());
    forEachEdge([&](std::size_t first, std::size_t last) {
      for (std::size_t i = first + 1; i < last; ++i) groups.join(sides_[first].triangle, sides_[i].triangle);
    });
    report_.component_of.resize(mesh_.triangles.size());
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      const std::uint32_t root = groups.root(t);
      if (root == t) {
        report_.component_of[t] = static_cast<std::uint32_t>(report_.components.size());
        report_.components.push_back({});
        report_.components.back().first_triangle = t;
      } else {
        report_.component_of[t] = report_.component_of[root];
      }
      ++report_.components[report_.component_of[t]].triangles;
    }
  }

  // --- self-intersections ---

  void findCrossings() {
    const CrossingTriangles found = findCrossingTriangles(mesh_, kMaxCrossingPairs);
    crosses_other_.resize(report_.components.size());
    crossings_known_ = !found.is_stopped;
    for (const auto& [t, u] : found.pairs) {
      Place place = triangleAt(t);
      place.triangles.push_back(u);
      add(DefectKind::SelfIntersection, std::move(place));
      const std::uint32_t ct = report_.component_of[t], cu = report_.component_of[u];
      if (ct != cu) crosses_other_[ct] = crosses_other_[cu] = true;
    }
    if (found.is_stopped) defect(DefectKind::SelfIntersection).is_lower_bound = true;
  }

  // --- orientation and nesting ---

  struct Enclosure {
    std::uint32_t component;
    int winding;  // of that component round the one asked for
  };

  void findOrientation() {
    if (!is_closed_ || report_.has(DefectKind::DegenerateFace) || report_.has(DefectKind::DuplicateFace)) {
      report_.not_checked.push_back(
          "Whether it is inside out, and whether parts lie within parts, was not checked: that takes a closed mesh of consistent winding.");
      return;
    }
    std::vector<Component>& components = report_.components;
    std::vector<double> volume(components.size()), area(components.size());
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      volume[report_.component_of[t]] += unitVolume(t);
      area[report_.component_of[t]] += unitArea(t);
    }
    // What the rounding of the coordinates alone can do to a sheet of no thickness.
    const double least_thickness = 16 * std::numeric_limits<double>::epsilon() * std::max(1.0, largest_coordinate_ / scale_);
    for (std::size_t c = 0; c < components.size(); ++c) {
      components[c].volume = volume[c] * scale_ * scale_ * scale_;
      if (!(2 * std::abs(volume[c]) > least_thickness * area[c])) add(DefectKind::NoVolume, triangleAt(components[c].first_triangle));
    }
    if (report_.has(DefectKind::NoVolume)) return;
    if (!crossings_known_) {
      report_.not_checked.push_back("Parts within parts were not searched for: too many triangles cross.");
      return;
    }

    // From the outside in: a component comes after all that enclose it.
    const std::vector<std::vector<Enclosure>> around = findEnclosures();
    std::vector<std::uint32_t> order(components.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return around[a].size() < around[b].size(); });
    std::vector<bool> is_turned(components.size());  // by itself or with what encloses it
    for (const std::uint32_t c : order) {
      Component& component = components[c];
      // Who is wound inward is turned together with all that lies in it: so a mesh that is wholly inside out keeps its hollows.
      int outside = 0;
      bool turned = false;
      std::size_t depth = 0;
      for (const Enclosure& e : around[c]) {
        outside += is_turned[e.component] ? -e.winding : e.winding;
        if (around[e.component].size() >= depth) depth = around[e.component].size(), turned = is_turned[e.component];
      }
      int own = (component.volume > 0) != turned ? 1 : -1;
      if (outside <= 0 && own < 0) turned = !turned, own = 1;
      is_turned[c] = turned;
      component.inside_out = turned;
      component.cavity = outside == 1 && own < 0;
      component.buried = !component.cavity && outside > 0;
    }
    for (const Component& component : components)
      if (component.inside_out) add(DefectKind::InsideOut, triangleAt(component.first_triangle));
  }

  /// For each component those that enclose it. A component that crosses others is in none: it has no one place.
  std::vector<std::vector<Enclosure>> findEnclosures() const {
    const std::vector<Component>& components = report_.components;
    std::vector<std::vector<Enclosure>> result(components.size());
    if (components.size() < 2) return result;
    std::vector<Eigen::AlignedBox3d> shadows;  // boxes of the triangles, seen along z
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      Eigen::AlignedBox3d box;
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d& p = mesh_.corner(t, k);
        box.extend(Eigen::Vector3d(p.x(), p.y(), 0));
      }
      shadows.push_back(box);
    }
    const BoxTree tree(shadows);
    for (std::uint32_t c = 0; c < components.size(); ++c) {
      if (crosses_other_[c]) continue;
      const std::uint32_t vertex = mesh_.triangles[components[c].first_triangle][0];
      const Eigen::Vector3d& p = mesh_.positions[vertex];
      std::map<std::uint32_t, int> windings;
      tree.searchWithin(Eigen::Vector3d(p.x(), p.y(), 0), 0, [&](std::size_t first, std::size_t count) {
        for (std::size_t slot = first; slot < first + count; ++slot) {
          const std::uint32_t t = tree.order()[slot];
          if (report_.component_of[t] != c) windings[report_.component_of[t]] += crossingAbove(t, points_[vertex]);
        }
      });
      for (const auto& [other, winding] : windings)
        if (winding != 0) result[c].push_back({other, winding});
    }
    return result;
  }

  /// +1 if the ray from `p` along +z leaves through the front of triangle `t`, -1 through its back, 0 if it misses. Exact, and
  /// consistent where the ray meets edges or corners: as if `p` were moved by an infinitely small step along +x and +y.
  int crossingAbove(std::uint32_t t, const Point& p) const {
    int turns = 0;  // winding number of the triangle's shadow round the shadow of p
    const auto flat = [](const Point& q) { return Kernel::Point_2(q.x(), q.y()); };
    for (std::size_t k = 0; k < 3; ++k) {
      const Point &a = points_[mesh_.triangles[t][k]], &b = points_[mesh_.triangles[t][(k + 1) % 3]];
      const bool up = a.y() <= p.y() && p.y() < b.y(), down = b.y() <= p.y() && p.y() < a.y();
      if (!up && !down) continue;
      const CGAL::Orientation side = CGAL::orientation(flat(a), flat(b), flat(p));
      if (up && side == CGAL::LEFT_TURN) ++turns;
      if (down && side == CGAL::RIGHT_TURN) --turns;
    }
    if (turns == 0) return 0;
    // A positive turn means that the front looks up: p is below the triangle if it is behind it.
    const Triangle& corners = mesh_.triangles[t];
    const CGAL::Orientation place = CGAL::orientation(points_[corners[0]], points_[corners[1]], points_[corners[2]], p);
    const bool is_below = turns > 0 ? place == CGAL::NEGATIVE : place == CGAL::POSITIVE;
    return is_below ? turns : 0;
  }

  const TriangleMesh& mesh_;
  MeshReport report_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  double scale_ = 1, largest_coordinate_ = 0;  // half the diagonal of the box; of any axis [mm]
  std::vector<Point> points_;
  std::vector<bool> has_edges_;  // for each triangle: three different corners
  std::vector<Side> sides_;
  bool is_closed_ = false, crossings_known_ = true;
  std::vector<bool> crosses_other_;  // for each component
};

std::string numberText(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string pointText(const Eigen::Vector3d& p) {
  return "(" + numberText(p.x()) + ", " + numberText(p.y()) + ", " + numberText(p.z()) + ")";
}

std::string counted(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

struct Wording {
  const char *one, *many;  // what is counted
  const char* advice;      // what to do
};

Wording wordingOf(DefectKind kind) {
  switch (kind) {
    case DefectKind::NoTriangles:
      return {"mesh", "meshes", "Export the surface as triangles."};
    case DefectKind::BadIndex:
      return {"triangle", "triangles", "Export the mesh again."};
    case DefectKind::NonFinite:
      return {"triangle", "triangles", "Export the mesh again, or delete these vertices and close the holes."};
    case DefectKind::Scale:
      return {"mesh", "meshes", "Give the unit of the file: the diagonal must lie between 1e-9 and 1e12 mm."};
    case DefectKind::DegenerateFace:
      return {"triangle", "triangles", "Remove zero-area faces and weld close vertices."};
    case DefectKind::DuplicateFace:
      return {"triangle", "triangles", "Remove duplicate faces."};
    case DefectKind::NonManifoldEdge:
      return {"edge", "edges", "Remove inner walls and fins, or separate bodies that share an edge."};
    case DefectKind::NonManifoldVertex:
      return {"vertex", "vertices", "Separate the bodies that meet in this vertex, or join them properly."};
    case DefectKind::ClashingWinding:
      return {"edge", "edges", "Make the face orientation consistent (\"recalculate normals\")."};
    case DefectKind::Border:
      return {"edge", "edges", "Close the holes, and weld vertices along cracks."};
    case DefectKind::NoVolume:
      return {"component", "components", "Give it a thickness, or delete it."};
    case DefectKind::InsideOut:
      return {"component", "components", "A build turns it round; so does \"flip normals\"."};
    case DefectKind::SelfIntersection:
      break;
  }
  return {"pair of triangles", "pairs of triangles", "Join overlapping bodies by a boolean union, and remove folds."};
}

}  // namespace

std::string_view name(DefectKind kind) {
  switch (kind) {
    case DefectKind::NoTriangles:
      return "no triangles";
    case DefectKind::BadIndex:
      return "missing vertex";
    case DefectKind::NonFinite:
      return "non-finite coordinate";
    case DefectKind::Scale:
      return "absurd size";
    case DefectKind::DegenerateFace:
      return "degenerate face";
    case DefectKind::DuplicateFace:
      return "duplicate face";
    case DefectKind::NonManifoldEdge:
      return "non-manifold edge";
    case DefectKind::NonManifoldVertex:
      return "non-manifold vertex";
    case DefectKind::ClashingWinding:
      return "clashing winding";
    case DefectKind::Border:
      return "border";
    case DefectKind::NoVolume:
      return "no volume";
    case DefectKind::InsideOut:
      return "inside out";
    case DefectKind::SelfIntersection:
      break;
  }
  return "self-intersection";
}

bool MeshReport::has(DefectKind kind) const { return count(kind) > 0; }

std::size_t MeshReport::count(DefectKind kind) const {
  for (const Defect& d : defects)
    if (d.kind == kind) return d.count;
  return 0;
}

std::size_t MeshReport::buriedComponents() const {
  return static_cast<std::size_t>(std::count_if(components.begin(), components.end(), [](const Component& c) { return c.buried; }));
}

std::string MeshReport::summary() const {
  std::string text;
  for (const Defect& d : defects) {
    const Wording wording = wordingOf(d.kind);
    text += std::string(name(d.kind)) + ": ";
    if (d.kind == DefectKind::Scale) {
      text += "the box is " + numberText(high.x() - low.x()) + " x " + numberText(high.y() - low.y()) + " x " +
              numberText(high.z() - low.z()) + " mm";
    } else if (d.kind == DefectKind::NoTriangles) {
      text += "the mesh is empty";
    } else {
      if (d.is_lower_bound) text += "more than ";
      text += counted(d.count, wording.one, wording.many);
    }
    if (d.kind == DefectKind::Border && !holes.empty())
      text += " round " + counted(holes.size(), "hole", "holes") + ", the longest " + numberText(holes[0].length) + " mm";
    if (!d.first.empty() && !d.first[0].triangles.empty()) {
      const Place& place = d.first[0];
      text += d.count == 1 ? "; at triangle " : "; the first at triangle ";
      text += std::to_string(place.triangles[0]);
      if (place.triangles.size() > 1) text += " and " + std::to_string(place.triangles[1]);
      if (d.kind == DefectKind::BadIndex)
        text += ", vertex " + std::to_string(place.vertices[0]);
      else
        text += ", " + pointText(place.point);
    }
    text += ". " + std::string(wording.advice) + "\n";
  }
  for (const std::string& sentence : not_checked) text += sentence + "\n";
  return text;
}

MeshReport checkMesh(const TriangleMesh& mesh) { return MeshCheck(mesh).run(); }

TriangleMesh orientOutward(TriangleMesh mesh, const MeshReport& report) {
  for (std::size_t t = 0; t < mesh.triangles.size() && t < report.component_of.size(); ++t)
    if (report.components[report.component_of[t]].inside_out) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  return mesh;
}

TriangleMesh withoutBuried(const TriangleMesh& mesh, const MeshReport& report) {
  if (report.buriedComponents() == 0) return mesh;
  TriangleMesh result;
  result.part_names = mesh.part_names;
  std::vector<std::uint32_t> index(mesh.positions.size(), kNone);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (report.components[report.component_of[t]].buried) continue;
    for (const std::uint32_t v : mesh.triangles[t]) index[v] = 0;
    result.triangles.push_back(mesh.triangles[t]);
    if (!mesh.part.empty()) result.part.push_back(mesh.part[t]);
  }
  for (std::size_t v = 0; v < index.size(); ++v) {
    if (index[v] == kNone) continue;
    index[v] = static_cast<std::uint32_t>(result.positions.size());
    result.positions.push_back(mesh.positions[v]);
  }
  for (Triangle& triangle : result.triangles)
    for (std::uint32_t& v : triangle) v = index[v];
  return result;
}

}  // namespace spheretree::builder
