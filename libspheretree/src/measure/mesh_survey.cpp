// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/mesh_survey.h"

#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <numbers>

#include "geometry/box_tree.h"
#include "geometry/distance_field.h"
#include "measure/cover_limits.h"
#include "measure/coverage.h"
#include "mesh/mesh_edges.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kSeam = 1e-4, kTiny = 0.01;           // as shares of the diagonal
constexpr double kShortOfEdge = 0.1;                   // a gap is a seam only if it is below this share of the adjacent border edges
constexpr double kSmallSolid = 3, kLargeSolid = 2000;  // range of diagonals of objects that are usually touched with a probe [mm]
constexpr std::size_t kInnerBalls = 4000;

struct BorderEdge {
  std::uint32_t from, to, triangle;  // in the direction of the triangle
};

std::vector<BorderEdge> borderEdges(const TriangleMesh& mesh, const std::vector<Side>& sides) {
  std::vector<BorderEdge> edges;
  forEachEdge(sides, [&](std::size_t first, std::size_t last) {
    if (last - first != 1) return;
    const Side& s = sides[first];
    edges.push_back({mesh.triangles[s.triangle][s.corner], mesh.triangles[s.triangle][(s.corner + 1) % 3], s.triangle});
  });
  return edges;
}

void measureLoop(const TriangleMesh& mesh, BorderShape& border) {
  // The vector area is normal to the plane on which the loop has its largest projection.
  Vector3d area = Vector3d::Zero();
  for (std::size_t i = 0; i < border.vertices.size(); ++i) {
    const Vector3d a = mesh.positions[border.vertices[i]] - border.centre;
    const Vector3d b = mesh.positions[border.vertices[(i + 1) % border.vertices.size()]] - border.centre;
    area += 0.5 * a.cross(b);
  }
  const double size = area.norm();
  if (!(size > 0)) return;
  double shadow = 0;
  for (std::size_t i = 0; i < border.vertices.size(); ++i) {
    const Vector3d a = mesh.positions[border.vertices[i]] - border.centre;
    const Vector3d side = mesh.positions[border.vertices[(i + 1) % border.vertices.size()]] - border.centre - a;
    border.off_plane = std::max(border.off_plane, std::abs(a.dot(area)) / size);
    shadow += (side - side.dot(area) / (size * size) * area).norm();
  }
  if (shadow > 0) border.roundness = 4 * std::numbers::pi * size / (shadow * shadow);
}

std::vector<BorderShape> findBorders(const TriangleMesh& mesh, const std::vector<BorderEdge>& edges) {
  Groups groups(mesh.positions.size());
  for (const BorderEdge& e : edges) groups.join(e.from, e.to);
  std::map<std::uint32_t, std::vector<BorderEdge>> by_root;
  for (const BorderEdge& e : edges) by_root[groups.root(e.from)].push_back(e);
  std::vector<BorderShape> borders;
  for (const auto& [root, own] : by_root) {
    BorderShape border;
    border.edges = own.size();
    std::map<std::uint32_t, std::uint32_t> next;
    std::map<std::uint32_t, int> ends;
    for (const BorderEdge& e : own) {
      border.length += (mesh.positions[e.to] - mesh.positions[e.from]).norm();
      next[e.from] = e.to;
      ++ends[e.from], ++ends[e.to];
    }
    border.is_loop = next.size() == own.size() && std::all_of(ends.begin(), ends.end(), [](const auto& e) { return e.second == 2; });
    border.centre = Vector3d::Zero();
    for (const auto& [vertex, count] : ends) border.centre += mesh.positions[vertex] / static_cast<double>(ends.size());
    if (border.is_loop) {
      std::uint32_t at = own[0].from;
      for (std::size_t i = 0; i < own.size(); ++i, at = next[at]) border.vertices.push_back(at);
      measureLoop(mesh, border);
    } else {
      for (const auto& [vertex, count] : ends) border.vertices.push_back(vertex);
    }
    borders.push_back(std::move(border));
  }
  std::stable_sort(borders.begin(), borders.end(), [](const BorderShape& a, const BorderShape& b) { return a.length > b.length; });
  return borders;
}

/// Finds border vertices that nearly meet another border vertex (a crack), or lie in the middle of another border edge
/// (a T-junction).
void findSeams(const TriangleMesh& mesh, const std::vector<BorderEdge>& edges, double tolerance, MeshSurvey& survey) {
  std::vector<Eigen::AlignedBox3d> boxes;
  std::map<std::uint32_t, double> shortest;  // shortest border edge at each border vertex
  for (const BorderEdge& e : edges) {
    Eigen::AlignedBox3d box(mesh.positions[e.from]);
    boxes.push_back(box.extend(mesh.positions[e.to]));
    const double length = (mesh.positions[e.to] - mesh.positions[e.from]).norm();
    for (const std::uint32_t v : {e.from, e.to}) {
      const auto found = shortest.try_emplace(v, length).first;
      found->second = std::min(found->second, length);
    }
  }
  const BoxTree tree(boxes);
  for (const auto& [vertex, length] : shortest) {
    const std::uint32_t v = vertex;
    const Vector3d& p = mesh.positions[v];
    const double reach = std::min(tolerance, kShortOfEdge * length);
    Seam crack{v, 0, std::numeric_limits<double>::infinity(), p}, junction = crack;
    tree.searchWithin(p, reach * reach, [&](std::size_t first, std::size_t count) {
      for (std::size_t slot = first; slot < first + count; ++slot) {
        const BorderEdge& e = edges[tree.order()[slot]];
        if (e.from == v || e.to == v) continue;
        const Vector3d &a = mesh.positions[e.from], along = mesh.positions[e.to] - a;
        for (const std::uint32_t end : {e.from, e.to}) {
          const double gap = (mesh.positions[end] - p).norm();
          if (gap < crack.gap || (gap == crack.gap && end < crack.other)) crack.gap = gap, crack.other = end;
        }
        const double share = along.squaredNorm() > 0 ? std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0) : 0.0;
        const double gap = (a + share * along - p).norm();
        if (gap < junction.gap || (gap == junction.gap && e.triangle < junction.other)) junction.gap = gap, junction.other = e.triangle;
      }
    });
    if (crack.gap <= reach)
      survey.cracks.push_back(crack);
    else if (junction.gap <= reach)
      survey.t_junctions.push_back(junction);
  }
}

/// Propagates the winding within each component from its first triangle; the minority has to be turned.
void findTurned(const TriangleMesh& mesh, const MeshReport& report, const std::vector<Side>& sides, MeshSurvey& survey) {
  std::vector<std::vector<std::pair<std::uint32_t, bool>>> beside(mesh.triangles.size());  // neighbour, same winding
  forEachEdge(sides, [&](std::size_t first, std::size_t last) {
    if (last - first != 2) return;
    const Side &a = sides[first], &b = sides[first + 1];
    beside[a.triangle].push_back({b.triangle, a.forward != b.forward});
    beside[b.triangle].push_back({a.triangle, a.forward != b.forward});
  });
  std::vector<char> side(mesh.triangles.size(), 0);  // 1: like its seed, 2: opposite
  std::vector<char> one_sided(report.components.size(), 0);
  for (std::uint32_t seed = 0; seed < side.size(); ++seed) {
    if (side[seed]) continue;
    std::vector<std::uint32_t> patch{seed};
    side[seed] = 1;
    std::size_t against = 0;
    bool is_one_sided = false;
    for (std::size_t i = 0; i < patch.size(); ++i) {
      for (const auto& [other, alike] : beside[patch[i]]) {
        const char wanted = alike ? side[patch[i]] : static_cast<char>(3 - side[patch[i]]);
        if (side[other] == 0) {
          side[other] = wanted;
          against += wanted == 2;
          patch.push_back(other);
        }
        is_one_sided = is_one_sided || side[other] != wanted;
      }
    }
    if (is_one_sided) one_sided[report.component_of[seed]] = 1;
    if (is_one_sided || against == 0) continue;
    const char fewer = 2 * against <= patch.size() ? 2 : 1;
    for (const std::uint32_t t : patch)
      if (side[t] == fewer) survey.turned.push_back(t);
  }
  std::sort(survey.turned.begin(), survey.turned.end());
  for (std::uint32_t c = 0; c < one_sided.size(); ++c)
    if (one_sided[c]) survey.one_sided.push_back(c);
}

void findTiny(const TriangleMesh& mesh, const MeshReport& report, double diagonal, MeshSurvey& survey) {
  std::vector<Eigen::AlignedBox3d> boxes(report.components.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) boxes[report.component_of[t]].extend(mesh.corner(t, k));
  for (std::uint32_t c = 0; c < boxes.size(); ++c)
    if (boxes[c].diagonal().norm() < kTiny * diagonal) survey.tiny.push_back(c);
}

void measureInside(const TriangleMesh& mesh, const MeshReport& report, Progress& progress, MeshSurvey& survey) {
  const TriangleMesh solid = withoutBuried(orientOutward(mesh, report), report);
  const DistanceField field(solid);
  const std::vector<SurfacePoint> points = spreadOverSurface(solid, kInnerBalls, 1);
  if (points.empty() || !(field.volume() > 0)) return;
  std::vector<double> diameters(points.size());
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    if (i % 64 == 0) progress.check();
    constexpr double kNoiseAngle = 0.5235987756;  // as in the limits of docs/measures.md
    diameters[i] = 2 * largestInnerBall(field, points[i].point, points[i].triangle, kNoiseAngle).radius;
  });
  std::sort(diameters.begin(), diameters.end());
  survey.has_inside = true;
  survey.thickness = {diameters.front(), diameters[diameters.size() / 20], diameters[diameters.size() / 2], diameters.back()};
  for (const double share : {1e-2, 5e-3, 2e-3, 1e-3, 5e-4}) {
    const double h = share * field.diagonal();
    double mean = 0;
    for (const double d : diameters) mean += 1 / (d + h) / static_cast<double>(diameters.size());
    survey.leaf_estimates.push_back(
        {h, static_cast<std::size_t>(std::ceil(kHexagonalCover * field.area() * mean / (2 * std::numbers::pi * h)))});
  }
}

std::string line(const char* format, auto... values) {
  char text[256];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

}  // namespace

std::string unitHint(double diagonal, double unit_mm) {
  if (diagonal >= kSmallSolid && diagonal <= kLargeSolid) return {};
  char text[96];
  std::snprintf(text, sizeof text, "the diagonal is %.3g mm, %s", diagonal, diagonal < kSmallSolid ? "very small" : "very large");
  std::string hint = text;
  std::string fitting;
  const std::pair<const char*, double> units[] = {{"mm", 1}, {"cm", 10}, {"in", 25.4}, {"m", 1000}};
  for (const auto& [unit, mm] : units)
    if (const double size = diagonal / unit_mm * mm; mm != unit_mm && size >= kSmallSolid && size <= kLargeSolid) {
      std::snprintf(text, sizeof text, "%s--unit %s makes it %.3g mm", fitting.empty() ? "" : ", ", unit, size);
      fitting += text;
    }
  if (!fitting.empty()) return hint + ": " + fitting + ".";
  return hint + (diagonal > kLargeSolid ? ": was it written in micrometres? Scale it where it was made." : ": scale it where it was made.");
}

MeshSurvey surveyMesh(const TriangleMesh& mesh, const MeshReport& report, Progress& progress, double unit_mm) {
  MeshSurvey survey;
  if (report.component_of.empty()) return survey;
  const double diagonal = (report.high - report.low).norm();
  survey.unit_hint = unitHint(diagonal, unit_mm);
  if (report.has(DefectKind::Scale)) return survey;
  const std::vector<Side> sides = sortedSides(mesh);
  if (report.has(DefectKind::Border)) {
    const std::vector<BorderEdge> edges = borderEdges(mesh, sides);
    survey.borders = findBorders(mesh, edges);
    findSeams(mesh, edges, kSeam * diagonal, survey);
  }
  progress.check();
  if (report.has(DefectKind::ClashingWinding)) findTurned(mesh, report, sides, survey);
  findTiny(mesh, report, diagonal, survey);
  if (report.fixable()) measureInside(mesh, report, progress, survey);
  return survey;
}

std::string summaryOf(const MeshSurvey& survey, const MeshReport& report) {
  constexpr std::size_t kListed = 5;
  std::string text;
  for (std::size_t i = 0; i < std::min(kListed, survey.borders.size()); ++i) {
    const BorderShape& b = survey.borders[i];
    text += line("border of %zu edge%s, %.4g mm long, about (%.4g, %.4g, %.4g): ", b.edges, b.edges == 1 ? "" : "s", b.length, b.centre.x(),
                 b.centre.y(), b.centre.z());
    text += b.is_loop ? line("a loop, within %.3g mm of a plane, roundness %.2f\n", b.off_plane, b.roundness) : "not a plain loop\n";
  }
  if (survey.borders.size() > kListed) text += line("%zu shorter borders\n", survey.borders.size() - kListed);
  const auto seams = [&](const std::vector<Seam>& all, const char* what, const char* advice) {
    if (all.empty()) return;
    double widest = 0;
    for (const Seam& s : all) widest = std::max(widest, s.gap);
    text += line("%s: %zu, up to %.3g mm wide; the first at vertex %u, (%.6g, %.6g, %.6g). %s\n", what, all.size(), widest, all[0].vertex,
                 all[0].point.x(), all[0].point.y(), all[0].point.z(), advice);
  };
  seams(survey.cracks, "cracks between border vertices", "Weld vertices that are this close.");
  seams(survey.t_junctions, "vertices on the side of a border edge (T-junctions)", "Split the edges there.");
  if (!survey.turned.empty())
    text += line("%zu triangle%s wound against the rest; the first is triangle %u\n", survey.turned.size(),
                 survey.turned.size() == 1 ? " is" : "s are", survey.turned[0]);
  for (const std::uint32_t c : survey.one_sided)
    text += line("the component from triangle %u on has one side only, as a Moebius strip: it cannot be wound\n",
                 report.components[c].first_triangle);
  if (!survey.tiny.empty())
    text += line("%zu tiny component%s, smaller than 1 %% of the mesh; the first from triangle %u on\n", survey.tiny.size(),
                 survey.tiny.size() == 1 ? "" : "s", report.components[survey.tiny[0]].first_triangle);
  if (!survey.unit_hint.empty()) text += survey.unit_hint + "\n";
  return text;
}

}  // namespace spheretree::builder
