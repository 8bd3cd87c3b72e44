// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/mesh_checks.h"

#include <tbb/parallel_sort.h>
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

#include "base/sum_in_order.h"
#include "mesh/crossing_triangles.h"
#include "mesh/mesh_edges.h"
#include "mesh/mesh_nesting.h"

namespace spheretree::builder {
namespace {

// Radii can be as small as 1e-3 of the diagonal, and are squared in float32, which has a range of 1e-38 to 3e38.
constexpr double kSmallestDiagonal = 1e-9, kLargestDiagonal = 1e12;  // [mm]
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

class MeshCheck {
 public:
  MeshCheck(const TriangleMesh& mesh, std::size_t places, const Progress& progress) : mesh_(mesh), places_(places), progress_(progress) {}

  MeshReport run() {
    report_.triangles = mesh_.triangles.size();
    report_.vertices = mesh_.positions.size();
    if (mesh_.triangles.empty()) {
      defect(DefectKind::NoTriangles).count = 1;
      return finish();
    }
    progress_.check();
    findBadNumbers();
    if (!report_.defects.empty()) {
      report_.not_checked.push_back("Nothing else was checked, because some triangles cannot be used.");
      return finish();
    }
    measure();
    findDegenerateFaces();
    findDuplicateFaces();
    progress_.check();
    sides_ = sortedSides(mesh_);
    progress_.check();
    findEdgeDefects();
    progress_.check();
    findNonManifoldVertices();
    nameComponents();
    if (report_.has(DefectKind::Scale)) {
      report_.not_checked.push_back("Volumes and self-intersections were not checked: correct the unit first.");
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
    if (d.first.size() < places_) d.first.push_back(std::move(place));
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
    // Halved before the difference, since it would overflow for huge coordinates.
    scale_ = (report_.high / 2 - report_.low / 2).stableNorm();
    const double diagonal = 2 * scale_;
    if (!(diagonal >= kSmallestDiagonal && diagonal <= kLargestDiagonal)) {
      add(DefectKind::Scale, {{}, {}, centre_});
      return;
    }
    double volume = 0, area = 0;
    addMeasures([&](std::uint32_t, double v, double a) { volume += v, area += a; });
    report_.volume = volume * scale_ * scale_ * scale_;
    report_.area = area * scale_ * scale_;
  }

  /// Relative to the centre of the box, in units of half its diagonal: far from the origin the terms would cancel.
  Eigen::Vector3d unitCorner(std::uint32_t t, int k) const { return (mesh_.corner(t, k) - centre_) / scale_; }
  double unitVolume(std::uint32_t t) const {
    const Eigen::Vector3d a = unitCorner(t, 0), b = unitCorner(t, 1), c = unitCorner(t, 2);
    return a.dot((b - a).cross(c - a)) / 6;  // differences first, so that small triangles keep their digits
  }
  double unitArea(std::uint32_t t) const {
    const Eigen::Vector3d a = unitCorner(t, 0), b = unitCorner(t, 1), c = unitCorner(t, 2);
    return (b - a).cross(c - a).norm() / 2;
  }

  /// Calls add(triangle, unit volume, unit area) in the order of the triangles.
  template <class Add>
  void addMeasures(Add&& add) const {
    const auto of = [&](std::size_t t) {
      return std::array<double, 2>{unitVolume(static_cast<std::uint32_t>(t)), unitArea(static_cast<std::uint32_t>(t))};
    };
    addInOrder<std::array<double, 2>>(mesh_.triangles.size(), of, [&](std::size_t t, const std::array<double, 2>& measures) {
      add(static_cast<std::uint32_t>(t), measures[0], measures[1]);
    });
  }

  // --- single triangles ---

  void findDegenerateFaces() {
    has_edges_.resize(mesh_.triangles.size());
    addInOrder<char>(
        mesh_.triangles.size(), [&](std::size_t t) { return isFlat(mesh_, t); },
        [&](std::size_t t, char is_flat) {
          const auto [a, b, c] = mesh_.triangles[t];
          has_edges_[t] = a != b && b != c && c != a;
          if (is_flat) add(DefectKind::DegenerateFace, triangleAt(static_cast<std::uint32_t>(t)));
        });
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
    tbb::parallel_sort(sorted.begin(), sorted.end());
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;  // the later triangle, and the first one with these corners
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

  template <class Visit>
  void forEachEdge(Visit&& visit) const {
    builder::forEachEdge(sides_, visit);
  }

  void findEdgeDefects() {
    std::array<std::vector<std::size_t>, 3> found;  // first sides of edges: of one triangle, of two that clash, of three or more
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
    // Corners at one vertex are connected if their triangles share an edge there.
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
    std::vector<std::uint32_t> fan(mesh_.positions.size(), kNone);  // fan of the first corner at the vertex; then kDone
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
    const CrossingTriangles found = findCrossingTriangles(mesh_, kMaxCrossingPairs, progress_);
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

  void findOrientation() {
    if (!is_closed_ || report_.has(DefectKind::DegenerateFace) || report_.has(DefectKind::DuplicateFace)) {
      report_.not_checked.push_back(
          "Inverted solids and parts within parts were not searched for: that needs a closed mesh with consistent winding.");
      return;
    }
    std::vector<Component>& components = report_.components;
    std::vector<double> volume(components.size()), area(components.size());
    addMeasures([&](std::uint32_t t, double v, double a) { volume[report_.component_of[t]] += v, area[report_.component_of[t]] += a; });
    // The thickness that rounding of the coordinates alone can give to a sheet without thickness.
    const double min_thickness = 16 * std::numeric_limits<double>::epsilon() * std::max(1.0, largest_coordinate_ / scale_);
    for (std::size_t c = 0; c < components.size(); ++c) {
      components[c].volume = volume[c] * scale_ * scale_ * scale_;
      if (!(2 * std::abs(volume[c]) > min_thickness * area[c])) add(DefectKind::NoVolume, triangleAt(components[c].first_triangle));
    }
    if (report_.has(DefectKind::NoVolume)) return;
    if (!crossings_known_) {
      report_.not_checked.push_back("Parts within parts were not searched for: too many triangles cross.");
      return;
    }

    // From the outside in: a component follows all components that enclose it.
    std::vector<std::uint32_t> first_triangle;
    for (const Component& component : components) first_triangle.push_back(component.first_triangle);
    const std::vector<std::vector<Enclosure>> around =
        findEnclosures(mesh_, report_.component_of, first_triangle, crosses_other_, progress_);
    std::vector<std::uint32_t> order(components.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return around[a].size() < around[b].size(); });
    std::vector<bool> is_turned(components.size());  // by itself or together with an enclosing component
    for (const std::uint32_t c : order) {
      Component& component = components[c];
      // A component that is wound inward is turned together with everything inside it: a mesh that is wholly inside out
      // keeps its cavities.
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

  const TriangleMesh& mesh_;
  std::size_t places_;
  const Progress& progress_;
  MeshReport report_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  double scale_ = 1, largest_coordinate_ = 0;  // half the diagonal of the box; largest absolute coordinate [mm]
  std::vector<bool> has_edges_;                // for each triangle: whether its three corners are different
  std::vector<Side> sides_;
  bool is_closed_ = false, crossings_known_ = true;
  std::vector<bool> crosses_other_;  // for each component
};

}  // namespace

MeshReport checkMesh(const TriangleMesh& mesh, std::size_t places, const Progress& progress) {
  return MeshCheck(mesh, places, progress).run();
}

}  // namespace spheretree::builder
