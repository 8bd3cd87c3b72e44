// SPDX-License-Identifier: GPL-3.0-or-later
#include "scan.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/boost/graph/Euler_operations.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include "spheretree/core/mesh_edit.h"

namespace spheretree::samples {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

constexpr double kGumReach = 7.5;   // of the gum beside the line of the teeth [mm]
constexpr double kViewAngle = 0.5;  // cosine of the largest angle of a view from above
constexpr std::int32_t kBracesLabel = 91;

/// Everything below is in the frame of the jaw: z out of the gum.
struct Jaw {
  std::vector<MouthTooth> teeth;
  std::vector<Vector2d> line;  // through the teeth, with its ends
  double lineDistance(const Vector2d& p) const {
    double smallest = 1e9;
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      const Vector2d way = line[i + 1] - line[i];
      const double t = std::clamp((p - line[i]).dot(way) / way.squaredNorm(), 0.0, 1.0);
      smallest = std::min(smallest, (p - line[i] - t * way).norm());
    }
    return smallest;
  }
  double gumHeight(const Vector2d& p) const {
    const double d = lineDistance(p);
    return 0.4 - 0.09 * d * d;
  }
};

/// Normal numbers as sums of twelve uniform ones: accurate enough, and equal with every library.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : generator_(seed) {}
  double uniform() { return static_cast<double>(generator_() >> 11) * 0x1p-53; }
  double normal() {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += uniform();
    return sum;
  }

 private:
  std::mt19937_64 generator_;
};

std::int32_t labelOf(const MouthTooth& tooth) { return std::stoi(tooth.name.substr(tooth.name.size() - 2)); }

void flip(TriangleMesh& mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
}

Vector3d inJaw(const Vector3d& p, bool upper, double level) { return {p.x(), p.y(), upper ? level - p.z() : p.z() - level}; }

void move(MouthTooth& tooth, const Vector3d& way) {
  tooth.centre += way;
  for (Vector3d& p : tooth.mesh.positions) p += way;
}

Jaw makeJaw(const Mouth& mouth, const ScanSettings& settings) {
  Jaw jaw;
  const std::size_t right = settings.upper ? 0 : 21, left = settings.upper ? 7 : 14;
  std::vector<std::size_t> along;
  for (std::size_t i = 7; i-- > 0;) along.push_back(right + i);
  for (std::size_t i = 0; i < 7; ++i) along.push_back(left + i);
  const double level = mouth.teeth[right].centre.z();
  for (std::size_t i = 0; i < along.size(); ++i) {
    MouthTooth tooth = mouth.teeth[along[i]];
    for (Vector3d& p : tooth.mesh.positions) p = inJaw(p, settings.upper, level);
    if (settings.upper) flip(tooth.mesh);
    tooth.centre.z() = 0;
    tooth.occlusal = {0, 0, 1};
    jaw.line.push_back(tooth.centre.head<2>());
    if (settings.crowding_mm > 0) move(tooth, (i % 2 == 0 ? 1 : -1) * settings.crowding_mm * tooth.buccal);
    if (labelOf(tooth) != settings.missing_fdi) jaw.teeth.push_back(tooth);
    if (settings.supernumerary && along[i] == left + 4) {
      MouthTooth extra = tooth;
      for (Vector3d& p : extra.mesh.positions) p = tooth.centre + 0.4 * (p - tooth.centre);
      move(extra, -8.2 * tooth.buccal + Vector3d(0, 0, -2.5));
      jaw.teeth.push_back(extra);
    }
  }
  const Vector2d begin = (jaw.line[0] - jaw.line[1]).normalized() * (mouth.teeth[along.front()].width / 2);
  const Vector2d end = (jaw.line.back() - jaw.line[jaw.line.size() - 2]).normalized() * (mouth.teeth[along.back()].width / 2);
  jaw.line.insert(jaw.line.begin(), jaw.line[0] + begin);
  jaw.line.push_back(jaw.line.back() + end);
  return jaw;
}

/// Splits edges at their midpoints until none is longer than `edge`, in both adjacent triangles.
void refine(TriangleMesh& mesh, double edge) {
  for (bool again = true; again;) {
    again = false;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) -> std::int64_t {
      if ((mesh.positions[a] - mesh.positions[b]).norm() <= edge) return -1;
      const auto [entry, is_new] = middles.emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.positions.size()));
      if (is_new) {
        const Vector3d p = (mesh.positions[a] + mesh.positions[b]) / 2;
        mesh.positions.push_back(p);
      }
      return entry->second;
    };
    std::vector<Triangle> finer;
    for (Triangle t : mesh.triangles) {
      std::array<std::int64_t, 3> m{};
      int cuts = 0;
      for (std::size_t k = 0; k < 3; ++k) m[k] = middle(t[k], t[(k + 1) % 3]), cuts += m[k] >= 0;
      again = again || cuts > 0;
      const auto at = [&](std::size_t k) { return static_cast<std::uint32_t>(m[k % 3]); };
      if (cuts == 0) {
        finer.push_back(t);
      } else if (cuts == 3) {
        finer.insert(finer.end(), {{t[0], at(0), at(2)}, {at(0), t[1], at(1)}, {at(2), at(1), t[2]}, {at(0), at(1), at(2)}});
      } else if (cuts == 1) {
        std::size_t k = 0;
        while (m[k] < 0) ++k;
        finer.push_back({t[k], at(k), t[(k + 2) % 3]});
        finer.push_back({at(k), t[(k + 1) % 3], t[(k + 2) % 3]});
      } else {
        std::size_t k = 0;  // the edge that is kept
        while (m[k] >= 0) ++k;
        finer.push_back({at(k + 2), at(k + 1), t[(k + 2) % 3]});
        finer.push_back({t[k], t[(k + 1) % 3], at(k + 1)});
        finer.push_back({t[k], at(k + 1), at(k + 2)});
      }
    }
    mesh.triangles = std::move(finer);
  }
}

/// The part of a tooth above the gum; `margin`: its border, in order.
TriangleMesh crownOf(TriangleMesh mesh, const Jaw& jaw, double edge, std::vector<std::uint32_t>& margin) {
  refine(mesh, edge);
  std::vector<double> above;
  for (const Vector3d& p : mesh.positions) above.push_back(p.z() - jaw.gumHeight(p.head<2>()));
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> cuts;
  const auto cut = [&](std::uint32_t a, std::uint32_t b) {
    const auto key = std::minmax(a, b);
    const auto [entry, is_new] = cuts.emplace(key, static_cast<std::uint32_t>(mesh.positions.size()));
    if (is_new) {
      const double t = std::clamp(above[key.first] / (above[key.first] - above[key.second]), 0.05, 0.95);
      const Vector3d p = mesh.positions[key.first] + t * (mesh.positions[key.second] - mesh.positions[key.first]);
      mesh.positions.push_back(p);
    }
    return entry->second;
  };
  std::vector<Triangle> kept;
  std::map<std::uint32_t, std::uint32_t> next;
  for (const Triangle& t : mesh.triangles) {
    const int count = (above[t[0]] > 0) + (above[t[1]] > 0) + (above[t[2]] > 0);
    if (count == 3) kept.push_back(t);
    if (count != 1 && count != 2) continue;
    std::size_t k = 0;  // the corner on its own side
    while ((above[t[k]] > 0) != (count == 1)) ++k;
    const std::uint32_t p = cut(t[k], t[(k + 1) % 3]), q = cut(t[k], t[(k + 2) % 3]);
    if (count == 1) {
      kept.push_back({t[k], p, q});
      next[p] = q;
    } else {
      kept.push_back({p, t[(k + 1) % 3], t[(k + 2) % 3]});
      kept.push_back({p, t[(k + 2) % 3], q});
      next[q] = p;
    }
  }
  mesh.triangles = std::move(kept);
  for (std::uint32_t v = next.begin()->first; margin.empty() || v != margin[0]; v = next.at(v)) margin.push_back(v);
  return mesh;
}

/// The scan under construction.
struct Growing {
  TriangleMesh mesh;
  std::vector<std::int32_t> labels;
  std::vector<std::vector<std::uint32_t>> margins;  // before the surface is triangulated anew beside them
  std::size_t crown_triangles = 0;                  // of the crowns, which come first, then those of the gum
  Vector3d gum_spot = Vector3d::Zero();             // far from the margins
};

void addCrowns(const Jaw& jaw, double edge, Growing& scan) {
  for (const MouthTooth& tooth : jaw.teeth) {
    std::vector<std::uint32_t> margin;
    const TriangleMesh crown = crownOf(tooth.mesh, jaw, edge, margin);
    const auto first = static_cast<std::uint32_t>(scan.mesh.positions.size());
    scan.mesh = joined(std::move(scan.mesh), crown);
    for (std::uint32_t& v : margin) v += first;
    scan.labels.resize(scan.mesh.positions.size(), labelOf(tooth));
    scan.margins.push_back(std::move(margin));
  }
  scan.crown_triangles = scan.mesh.triangles.size();
}

bool isWithin(const Vector2d& p, const std::vector<Vector2d>& polygon) {
  bool in = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++)
    if ((polygon[i].y() > p.y()) != (polygon[j].y() > p.y()) &&
        p.x() < polygon[i].x() + (polygon[j].x() - polygon[i].x()) * (p.y() - polygon[i].y()) / (polygon[j].y() - polygon[i].y()))
      in = !in;
  return in;
}

/// The gum between the margins: a Delaunay triangulation of a grid, seen from above.
void addGum(const Jaw& jaw, double edge, Growing& scan) {
  using Vertex = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, Kernel>;
  using Face = CGAL::Constrained_triangulation_face_base_2<Kernel>;
  using Cdt = CGAL::Constrained_Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<Vertex, Face>>;
  Cdt cdt;
  std::vector<std::vector<Vector2d>> holes;
  std::vector<Vector2d> near;
  for (const std::vector<std::uint32_t>& margin : scan.margins) {
    std::vector<Cdt::Vertex_handle> handles;
    holes.emplace_back();
    for (const std::uint32_t v : margin) {
      const Vector2d p = scan.mesh.positions[v].head<2>();
      holes.back().push_back(p);
      handles.push_back(cdt.insert({p.x(), p.y()}));
      handles.back()->info() = v;
    }
    for (std::size_t i = 0; i < handles.size(); ++i) cdt.insert_constraint(handles[i], handles[(i + 1) % handles.size()]);
    near.insert(near.end(), holes.back().begin(), holes.back().end());
  }
  const auto isFree = [&](const Vector2d& p, double gap) {
    for (const auto& hole : holes)
      if (isWithin(p, hole)) return false;
    for (const Vector2d& q : near)
      if ((q - p).squaredNorm() < gap * gap) return false;
    return true;
  };
  Eigen::AlignedBox2d box;
  for (const Vector2d& p : jaw.line) box.extend(p);
  const double row = edge * std::sqrt(0.75);
  int odd = 0;
  for (double y = box.min().y() - 10; y < box.max().y() + 10; y += row, ++odd)
    for (double x = box.min().x() - 10 + (odd % 2) * edge / 2; x < box.max().x() + 10; x += edge) {
      const Vector2d p(x, y);
      if (jaw.lineDistance(p) > kGumReach || !isFree(p, 0.6 * edge)) continue;
      const auto v = cdt.insert({x, y});
      v->info() = static_cast<std::uint32_t>(scan.mesh.positions.size());
      scan.mesh.positions.push_back({x, y, jaw.gumHeight(p)});
      scan.labels.push_back(0);
    }
  std::vector<Triangle> triangles;
  for (auto f = cdt.finite_faces_begin(); f != cdt.finite_faces_end(); ++f) {
    const Triangle t{f->vertex(0)->info(), f->vertex(1)->info(), f->vertex(2)->info()};
    Vector2d middle(0, 0);
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector2d a = scan.mesh.positions[t[k]].head<2>(), b = scan.mesh.positions[t[(k + 1) % 3]].head<2>();
      middle += a / 3;
      longest = std::max(longest, (a - b).norm());
    }
    const bool in_hole = std::any_of(holes.begin(), holes.end(), [&](const auto& hole) { return isWithin(middle, hole); });
    if (!in_hole && longest < 4 * edge && jaw.lineDistance(middle) < kGumReach) triangles.push_back(t);
  }
  for (Triangle& t : triangles) std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  std::sort(triangles.begin(), triangles.end());
  scan.mesh.triangles.insert(scan.mesh.triangles.end(), triangles.begin(), triangles.end());
  scan.gum_spot = scan.mesh.positions[scan.labels.size() - 200];
}

Kernel::Point_3 toPoint(const Vector3d& p) { return {p.x(), p.y(), p.z()}; }

/// Triangles that can be searched; the tree refers to the vector, so that it cannot be copied.
struct SearchedTriangles {
  using Primitive = CGAL::AABB_triangle_primitive<Kernel, std::vector<Kernel::Triangle_3>::const_iterator>;
  explicit SearchedTriangles(const TriangleMesh& mesh) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      triangles.emplace_back(toPoint(mesh.corner(t, 0)), toPoint(mesh.corner(t, 1)), toPoint(mesh.corner(t, 2)));
    tree.insert(triangles.cbegin(), triangles.cend());
  }
  SearchedTriangles(const SearchedTriangles&) = delete;
  SearchedTriangles& operator=(const SearchedTriangles&) = delete;

  std::vector<Kernel::Triangle_3> triangles;
  CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>> tree;
};

/// True for the vertices within about three edges of a margin.
std::vector<char> nearMargins(const Growing& scan, double edge) {
  using Cell = std::array<int, 3>;
  const auto cellOf = [&](const Vector3d& p) {
    const Vector3d cell = (p / (2 * edge)).array().floor();
    return Cell{static_cast<int>(cell.x()), static_cast<int>(cell.y()), static_cast<int>(cell.z())};
  };
  std::set<Cell> cells;
  for (const std::vector<std::uint32_t>& margin : scan.margins)
    for (const std::uint32_t v : margin)
      for (int i = 0; i < 27; ++i) {
        const Cell c = cellOf(scan.mesh.positions[v]);
        cells.insert({c[0] + i % 3 - 1, c[1] + i / 3 % 3 - 1, c[2] + i / 9 - 1});
      }
  std::vector<char> is_near;
  for (const Vector3d& p : scan.mesh.positions) is_near.push_back(cells.contains(cellOf(p)));
  return is_near;
}

using Surface = CGAL::Surface_mesh<Kernel::Point_3>;

/// Triangles taken out of a mesh to be triangulated anew, as a mesh of their own: its border stays as it is, so that
/// the result can be put back.
struct Patch {
  Surface surface;
  Surface::Property_map<Surface::Vertex_index, std::uint32_t> vertex;  // of the mesh, for vertices of the border
};

/// Moves the triangles between marked vertices from `mesh` into a patch, but for those that would give it border edges
/// longer than 4/3 of `edge`, which CGAL's remeshing forbids.
Patch takePatch(const std::vector<char>& marked, double edge, TriangleMesh& mesh) {
  Patch patch;
  Surface& surface = patch.surface;
  patch.vertex = surface.add_property_map<Surface::Vertex_index, std::uint32_t>("v:vertex").first;
  auto triangle = surface.add_property_map<Surface::Face_index, Triangle>("f:triangle").first;
  std::map<std::uint32_t, Surface::Vertex_index> vertex_of;
  const auto vertexOf = [&](std::uint32_t v) {
    const auto [found, is_new] = vertex_of.try_emplace(v);
    if (is_new) patch.vertex[found->second = surface.add_vertex(toPoint(mesh.positions[v]))] = v;
    return found->second;
  };
  std::vector<Triangle> kept;
  for (const Triangle& c : mesh.triangles) {
    const bool is_marked = marked[c[0]] && marked[c[1]] && marked[c[2]];
    const Surface::Face_index f = is_marked ? surface.add_face(vertexOf(c[0]), vertexOf(c[1]), vertexOf(c[2])) : Surface::null_face();
    if (f == Surface::null_face())
      kept.push_back(c);
    else
      triangle[f] = c;
  }
  const auto hasLongBorder = [&](Surface::Face_index f) {
    for (const Surface::Halfedge_index h : surface.halfedges_around_face(surface.halfedge(f)))
      if (surface.is_border(surface.opposite(h)) && CGAL::Polygon_mesh_processing::edge_length(h, surface) > 1.33 * edge) return true;
    return false;
  };
  for (bool any = true; any;) {
    std::vector<Surface::Face_index> left_out;
    std::copy_if(surface.faces_begin(), surface.faces_end(), std::back_inserter(left_out), hasLongBorder);
    for (const Surface::Face_index f : left_out) {
      kept.push_back(triangle[f]);
      CGAL::Euler::remove_face(surface.halfedge(f), surface);
    }
    any = !left_out.empty();
  }
  mesh.triangles = std::move(kept);
  return patch;
}

void dropUnused(Growing& scan) {
  std::vector<char> is_used(scan.mesh.positions.size(), 0);
  for (const Triangle& t : scan.mesh.triangles)
    for (const std::uint32_t v : t) is_used[v] = 1;
  std::size_t used = 0;
  for (std::size_t v = 0; v < is_used.size(); ++v)
    if (is_used[v]) scan.labels[used++] = scan.labels[v];
  scan.labels.resize(used);
  dropUnusedVertices(scan.mesh);
}

/// Triangulates the surface anew near the margins, because the triangles of a scanner do not follow them: vertices lie
/// anywhere beside a margin and have the label of the side on which they are.
void forgetMargins(double edge, Growing& scan) {
  const std::vector<char> is_near = nearMargins(scan, edge);
  TriangleMesh old{scan.mesh.positions, {}, {}, {}};
  std::vector<std::int32_t> label_of_old;
  for (std::size_t t = 0; t < scan.mesh.triangles.size(); ++t) {
    const Triangle& c = scan.mesh.triangles[t];
    if (!(is_near[c[0]] && is_near[c[1]] && is_near[c[2]])) continue;
    old.triangles.push_back(c);
    label_of_old.push_back(t < scan.crown_triangles ? scan.labels[c[0]] : 0);
  }
  const SearchedTriangles search(old);
  const auto labelAt = [&](const Kernel::Point_3& p) {
    return label_of_old[static_cast<std::size_t>(search.tree.closest_point_and_primitive(p).second - search.triangles.cbegin())];
  };
  Patch patch = takePatch(is_near, edge, scan.mesh);
  Surface& surface = patch.surface;
  CGAL::Polygon_mesh_processing::isotropic_remeshing(surface.faces(), edge, surface,
                                                     CGAL::parameters::number_of_iterations(3).protect_constraints(true));
  surface.collect_garbage();
  for (const Surface::Vertex_index v : surface.vertices()) {
    if (surface.is_border(v)) continue;
    const Kernel::Point_3& p = surface.point(v);
    patch.vertex[v] = static_cast<std::uint32_t>(scan.mesh.positions.size());
    scan.mesh.positions.emplace_back(p.x(), p.y(), p.z());
    scan.labels.push_back(0);
  }
  for (const Surface::Face_index f : surface.faces()) {
    const auto h = surface.halfedge(f);
    scan.mesh.triangles.push_back(
        {patch.vertex[surface.source(h)], patch.vertex[surface.target(h)], patch.vertex[surface.target(surface.next(h))]});
  }
  for (std::size_t v = 0; v < scan.labels.size(); ++v)
    if (v >= is_near.size() || is_near[v]) scan.labels[v] = labelAt(toPoint(scan.mesh.positions[v]));
  dropUnused(scan);
}

std::vector<Vector3d> normalsOf(const TriangleMesh& mesh) {
  std::vector<Vector3d> normals(mesh.positions.size(), Vector3d::Zero());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t])
      normals[v] += (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
  for (Vector3d& n : normals) n.normalize();
  return normals;
}

/// Removes the surfaces that some views from above do not see, because they face away or are hidden.
void removeHidden(Growing& scan) {
  const SearchedTriangles search(scan.mesh);
  std::vector<Vector3d> views{{0, 0, 1}};
  for (const double c : {0.8, kViewAngle})
    for (const Vector2d& d : circleCorners(3)) views.push_back({std::sqrt(1 - c * c) * d.x(), std::sqrt(1 - c * c) * d.y(), c});
  std::vector<Triangle> seen;
  for (const Triangle& t : scan.mesh.triangles) {
    const Vector3d &a = scan.mesh.positions[t[0]], &b = scan.mesh.positions[t[1]], &c = scan.mesh.positions[t[2]];
    const Vector3d n = (b - a).cross(c - a).normalized(), from = (a + b + c) / 3 + 1e-3 * n;
    const bool is_seen = std::any_of(views.begin(), views.end(), [&](const Vector3d& view) {
      return n.dot(view) > 0.1 && !search.tree.do_intersect(Kernel::Ray_3(toPoint(from), Kernel::Vector_3(view.x(), view.y(), view.z())));
    });
    if (is_seen) seen.push_back(t);
  }
  scan.mesh.triangles = std::move(seen);
}

void addBraces(const Jaw& jaw, Growing& scan) {
  const std::vector<Vector3d> normals = normalsOf(scan.mesh);
  for (const MouthTooth& tooth : jaw.teeth) {
    const Vector3d spot = tooth.centre + Vector3d(0, 0, 4);
    for (std::size_t v = 0; v < scan.labels.size(); ++v) {
      const Vector3d arm = scan.mesh.positions[v] - spot;
      const double out = arm.dot(tooth.buccal), aside = arm.dot(tooth.mesial);
      if (scan.labels[v] != labelOf(tooth) || out < 0.5 || std::abs(aside) > 1.6 || std::abs(arm.z()) > 1.4) continue;
      if (normals[v].dot(tooth.buccal) < 0.5) continue;
      scan.labels[v] = kBracesLabel;
      const double inner = std::min(1.0, 2 * std::min(1.6 - std::abs(aside), 1.4 - std::abs(arm.z())));
      scan.mesh.positions[v] += 0.8 * inner * tooth.buccal;
    }
  }
}

void addDoubleLayer(Growing& scan, double edge) {
  const std::size_t before = scan.mesh.triangles.size();
  std::map<std::uint32_t, std::uint32_t> copies;
  for (std::size_t t = 0; t < before; ++t) {
    Triangle copy = scan.mesh.triangles[t];
    const bool near =
        std::all_of(copy.begin(), copy.end(), [&](std::uint32_t v) { return (scan.mesh.positions[v] - scan.gum_spot).norm() < 8 * edge; });
    if (!near) continue;
    for (std::uint32_t& v : copy) {
      if (scan.mesh.positions[v].x() < scan.gum_spot.x()) continue;  // that side is connected
      const auto [entry, is_new] = copies.emplace(v, static_cast<std::uint32_t>(scan.mesh.positions.size()));
      if (is_new) {
        const Vector3d p = scan.mesh.positions[v] + Vector3d(0, 0, 0.05);
        scan.mesh.positions.push_back(p);
        scan.labels.push_back(0);
      }
      v = entry->second;
    }
    if (copy != scan.mesh.triangles[t]) scan.mesh.triangles.push_back(copy);
  }
}

void roughen(const ScanSettings& settings, Growing& scan) {
  Noise noise(settings.seed);
  const std::vector<Vector3d> normals = normalsOf(scan.mesh);
  if (settings.noise_mm > 0)
    for (std::size_t v = 0; v < normals.size(); ++v)
      if (normals[v].allFinite()) scan.mesh.positions[v] += settings.noise_mm * noise.normal() * normals[v];
  for (int i = 0; i < settings.holes; ++i) {
    const Vector3d spot = scan.mesh.positions[static_cast<std::size_t>(noise.uniform() * static_cast<double>(normals.size()))];
    std::erase_if(scan.mesh.triangles, [&](const Triangle& t) { return (scan.mesh.positions[t[0]] - spot).norm() < 0.75; });
  }
  if (!settings.jagged) return;
  std::vector<std::int32_t> other = scan.labels;
  for (const Triangle& t : scan.mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      if (scan.labels[t[k]] != scan.labels[t[(k + 1) % 3]]) other[t[k]] = scan.labels[t[(k + 1) % 3]];
  for (std::size_t v = 0; v < other.size(); ++v)
    if (noise.uniform() < 0.5) scan.labels[v] = other[v];
}

}  // namespace

SampleScan makeScan(const Mouth& mouth, const ScanSettings& settings) {
  const Jaw jaw = makeJaw(mouth, settings);
  Growing scan;
  addCrowns(jaw, settings.edge_mm, scan);
  addGum(jaw, settings.edge_mm, scan);
  SampleScan out;
  const double level = mouth.teeth[settings.upper ? 0 : 21].centre.z();
  const auto toWorld = [&](const Vector3d& p) -> Vector3d { return {p.x(), p.y(), settings.upper ? level - p.z() : p.z() + level}; };
  for (const std::vector<std::uint32_t>& margin : scan.margins) {
    out.margins.emplace_back();
    for (const std::uint32_t v : margin) out.margins.back().push_back(toWorld(scan.mesh.positions[v]));
  }
  forgetMargins(settings.edge_mm, scan);
  if (settings.braces) addBraces(jaw, scan);
  if (settings.hidden_removed) removeHidden(scan);
  if (settings.double_layer) addDoubleLayer(scan, settings.edge_mm);
  roughen(settings, scan);
  dropUnused(scan);
  out.labels = std::move(scan.labels);
  out.mesh = std::move(scan.mesh);
  for (Vector3d& p : out.mesh.positions) p = toWorld(p);
  if (settings.upper) flip(out.mesh);
  out.teeth = jaw.teeth;
  for (MouthTooth& tooth : out.teeth) {
    for (Vector3d& p : tooth.mesh.positions) p = toWorld(p);
    tooth.centre = toWorld(tooth.centre);
    if (settings.upper) {
      flip(tooth.mesh);
      tooth.occlusal = {0, 0, -1};
    }
  }
  return out;
}

std::string labelsText(const SampleScan& scan, const std::string& patient, bool upper) {
  std::string labels, instances;
  std::map<std::int32_t, int> instance_of{{0, 0}};
  for (const std::int32_t label : scan.labels) instance_of.emplace(label, 0);
  int count = 0;
  for (auto& [label, instance] : instance_of) instance = label == 0 ? 0 : ++count;
  for (const std::int32_t label : scan.labels) {
    labels += (labels.empty() ? "" : ", ") + std::to_string(label);
    instances += (instances.empty() ? "" : ", ") + std::to_string(instance_of.at(label));
  }
  return "{\"id_patient\": \"" + patient + "\", \"jaw\": \"" + (upper ? "upper" : "lower") + "\",\n \"labels\": [" + labels +
         "],\n \"instances\": [" + instances + "]}\n";
}

}  // namespace spheretree::samples
