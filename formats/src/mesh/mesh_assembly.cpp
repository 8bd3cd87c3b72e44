// SPDX-License-Identifier: Apache-2.0
#include "mesh/mesh_assembly.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <utility>

#include "spheretree/core/mesh_edit.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/safe_name.h"
#include "text/text_scan.h"

namespace spheretree::formats {
namespace {

constexpr std::size_t kMaxConcaveCorners = 4096;  // ear clipping takes quadratic time

using Point2 = std::array<double, 2>;

double turn(const Point2& a, const Point2& b, const Point2& c) { return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]); }

/// Ear clipping of a counter-clockwise polygon: emits index triples into `points`. Ears are cut in order, so that the
/// result depends only on the polygon; a polygon without ears (it crosses itself) is cut into a fan.
template <class Emit>
void clipEars(std::span<const Point2> points, Emit&& emit) {
  const std::size_t n = points.size();
  std::vector<std::size_t> next(n), previous(n);
  for (std::size_t i = 0; i < n; ++i) next[i] = (i + 1) % n, previous[i] = (i + n - 1) % n;
  std::vector<std::size_t> reflex;
  for (std::size_t i = 0; i < n; ++i)
    if (!(turn(points[previous[i]], points[i], points[next[i]]) > 0)) reflex.push_back(i);
  const auto isEar = [&](std::size_t i) {
    const Point2 &a = points[previous[i]], &b = points[i], &c = points[next[i]];
    if (!(turn(a, b, c) > 0)) return false;
    for (const std::size_t r : reflex) {
      const Point2& p = points[r];
      if (p == a || p == b || p == c) continue;
      if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
    }
    return true;
  };
  std::vector<char> ear(n);
  for (std::size_t i = 0; i < n; ++i) ear[i] = isEar(i);
  std::size_t at = 0, left = n, since_last = 0;
  while (left > 3 && since_last <= left) {
    if (!ear[at]) {
      at = next[at];
      ++since_last;
      continue;
    }
    const std::size_t p = previous[at], q = next[at];
    emit(p, at, q);
    next[p] = q, previous[q] = p;
    --left;
    since_last = 0;
    std::erase(reflex, at);
    for (const std::size_t i : {p, q})
      if (turn(points[previous[i]], points[i], points[next[i]]) > 0) std::erase(reflex, i);
    ear[p] = isEar(p);
    ear[q] = isEar(q);
    at = q;
  }
  for (std::size_t i = next[at]; next[i] != at; i = next[i]) emit(at, i, next[i]);
}

}  // namespace

MeshAssembly::MeshAssembly(std::string name, double unit_mm) : name_(std::move(name)), unit_mm_(unit_mm) {
  if (!(std::isfinite(unit_mm) && unit_mm > 0)) throw std::invalid_argument("the unit of a mesh must be a finite number of mm above 0");
}

void MeshAssembly::refuse(const std::string& what) const { throw FormatError(name_ + ": " + what); }

void MeshAssembly::refuseLine(std::size_t line, const std::string& what) const { refuse("line " + std::to_string(line) + ": " + what); }

double MeshAssembly::number(std::string_view word, std::size_t line) const {
  double value = 0;
  switch (parseDouble(word, value)) {
    case NumberFault::None:
      return value;
    case NumberFault::OutOfRange:
      refuseLine(line, inQuotes(word) + " is out of the range of double precision. Write the mesh in a suitable unit.");
    case NumberFault::Malformed:
      break;
  }
  refuseLine(line, inQuotes(word) + " is not a number. Numbers are written with a decimal point, such as -1.5 or 2e-3.");
}

void MeshAssembly::takeVertex(std::string_view& text, std::size_t line) {
  double p[3];
  for (double& coordinate : p) {
    const std::string_view word = takeWord(text);
    if (word.empty())
      refuseLine(line, "a vertex needs three coordinates on its line. The file is cut off or damaged: copy or export it again.");
    coordinate = number(word, line);
  }
  addVertex(p[0], p[1], p[2], line);
}

bool MeshAssembly::addVertex(double x, double y, double z, std::size_t line) {
  // Adding zero turns -0 into 0: both are the same position, and must have the same bits.
  const Eigen::Vector3d p(x * unit_mm_ + 0.0, y * unit_mm_ + 0.0, z * unit_mm_ + 0.0);
  if (positions_.size() == kNone) refuse("has more than 4294967295 vertices, the limit for a mesh.");
  if (!p.allFinite()) bad_vertices_.push_back({vertexCount(), line, {x, y, z}});
  positions_.push_back(p);
  return p.allFinite();
}

void MeshAssembly::refuseUsed(const BadVertex& bad) const {
  const auto& [x, y, z] = bad.place;
  const std::string what = "vertex " + std::to_string(bad.vertex) + ", counted from 0, at (" + shortest(x) + ", " + shortest(y) + ", " +
                           shortest(z) + "), is not finite in mm, and a face uses it. Export the mesh again, " +
                           (std::isfinite(x + y + z) ? "or choose a smaller unit." : "or delete the vertex and the faces at it.");
  if (bad.line > 0) refuseLine(bad.line, what);
  refuse(what);
}

void MeshAssembly::reserve(std::size_t vertices, std::size_t triangles) {
  positions_.reserve(vertices);
  triangles_.reserve(triangles);
}

void MeshAssembly::beginPart(std::string_view part_name) {
  part_name_ = part_name;
  part_entered_ = false;
}

void MeshAssembly::setColour(const std::array<std::uint8_t, 3>& colour) {
  if (colours_.empty()) colours_.assign(triangles_.size(), kWhite);
  colour_ = colour;
}

void MeshAssembly::renameParts(std::span<const std::string> names) {
  std::vector<std::string> distinct;
  std::map<std::string, std::uint32_t> index;
  for (const std::string& name : names)
    if (index.try_emplace(name, static_cast<std::uint32_t>(distinct.size())).second) distinct.push_back(name);
  for (std::uint32_t& part : part_) part = index.at(names[part]);
  part_names_ = std::move(distinct);
}

void MeshAssembly::addTriangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t face) {
  if (!part_entered_) {
    const auto [entry, is_new] = part_index_.try_emplace(part_name_, static_cast<std::uint32_t>(part_names_.size()));
    if (is_new) part_names_.push_back(part_name_);
    current_part_ = entry->second;
    part_entered_ = true;
  }
  triangles_.push_back({a, b, c});
  part_.push_back(current_part_);
  face_of_triangle_.push_back(face);
  if (!colours_.empty() || colour_ != kWhite) colours_.push_back(colour_);
}

void MeshAssembly::addPolygon(std::span<const std::uint32_t> corners, std::uint32_t face) {
  if (corners.size() == 3) return addTriangle(corners[0], corners[1], corners[2], face);
  if (corners.size() < 3) {
    ++short_faces_;
    return;
  }
  ++cut_polygons_;
  const auto point = [&](std::size_t i) -> const Eigen::Vector3d& { return positions_[corners[i]]; };
  // Scaled to 1, so that products of very large or small coordinates stay in range.
  Eigen::Vector3d low = point(0), high = point(0);
  for (std::size_t i = 1; i < corners.size(); ++i) low = low.cwiseMin(point(i)), high = high.cwiseMax(point(i));
  const Eigen::Vector3d half = high / 2 - low / 2;
  const double scale = half.maxCoeff() > 0 ? half.maxCoeff() : 1.0;
  const auto arm = [&](std::size_t i) -> Eigen::Vector3d { return ((point(i) / 2 - point(0) / 2) / scale).eval(); };
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // twice the vector area
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) normal += arm(i).cross(arm(i + 1));
  bool fan_fits = true;
  for (std::size_t i = 1; i + 1 < corners.size() && fan_fits; ++i) fan_fits = arm(i).cross(arm(i + 1)).dot(normal) > 0;
  if (fan_fits) {
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) addTriangle(corners[0], corners[i], corners[i + 1], face);
    return;
  }
  if (corners.size() > kMaxConcaveCorners)
    refuse("a concave face has " + std::to_string(corners.size()) + " corners; at most " + std::to_string(kMaxConcaveCorners) +
           " are read. Cut it into triangles in the program that made the mesh.");
  // Projected along the axis nearest to the normal, seen from its tip.
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  std::vector<Point2> points;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3d p = arm(i);
    points.push_back(normal[axis] >= 0 ? Point2{p[u], p[v]} : Point2{p[v], p[u]});
  }
  clipEars(points, [&](std::size_t a, std::size_t b, std::size_t c) { addTriangle(corners[a], corners[b], corners[c], face); });
}

MeshFile MeshAssembly::finish(std::string format) {
  if (triangles_.empty())
    throw NoTriangleError(name_ + ": has no triangle" +
                          std::string(short_faces_         ? ", only faces of fewer than three corners"
                                      : positions_.empty() ? " and no vertex"
                                                           : ", only vertices, lines or points") +
                          ". A solid needs faces: export the surface as triangles.");
  MeshFile file;
  file.unit_mm = unit_mm_;
  file.face_of_triangle = std::move(face_of_triangle_);
  file.faces = faces_;
  if (std::adjacent_find(colours_.begin(), colours_.end(), std::not_equal_to<>()) != colours_.end()) file.colours = std::move(colours_);
  file.format = std::move(format);

  file.mesh.positions = std::move(positions_);
  file.mesh.triangles = std::move(triangles_);
  file.vertex_of_file = weldEqualVertices(file.mesh);
  for (const BadVertex& bad : bad_vertices_)
    if (file.vertex_of_file[bad.vertex] != kNone) refuseUsed(bad);
  const auto unused = static_cast<std::size_t>(std::count(file.vertex_of_file.begin(), file.vertex_of_file.end(), kNone));
  if (part_names_.size() > 1 || !part_names_[0].empty()) {
    file.mesh.part = std::move(part_);
    file.mesh.part_names = std::move(part_names_);
    std::size_t recoded = 0;
    for (std::string& part : file.mesh.part_names) {
      const std::string utf8 = asUtf8(part);
      recoded += utf8 != part;
      part = utf8;
    }
    if (recoded > 0)
      note(std::to_string(recoded) + (recoded == 1 ? " name of a part is" : " names of parts are") +
           " not UTF-8; they are read as Latin-1.");
  }

  const auto noteCount = [&](std::size_t count, const char* one, const char* many, const char* what) {
    if (count) note(std::to_string(count) + (count == 1 ? one : many) + what);
  };
  noteCount(cut_polygons_, " polygon was", " polygons were", " cut into triangles; from here on faces are counted as triangles.");
  noteCount(short_faces_, " face", " faces", " of fewer than three corners left out.");
  noteCount(unused, " vertex", " vertices", " that no face uses left out.");
  noteCount(bad_vertices_.size(), " of them is", " of them are", " not at a finite point.");
  file.notes = std::move(notes_);
  return file;
}

}  // namespace spheretree::formats
