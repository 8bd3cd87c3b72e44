// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/split/scan_input.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>
#include <set>

#include "pipeline/sound_mesh.h"
#include "pipeline/split/tooth_numbers.h"
#include "program_end.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/ply.h"
#include "spheretree/formats/scan_labels.h"

namespace spheretree::pipeline {
namespace {

using formats::FormatError;
using formats::MeshFile;
using Labels = std::vector<std::int32_t>;

constexpr std::size_t kMaxColours = 100;        // more colours are a texture, not labels
constexpr std::int32_t kFirstUnnumbered = 101;  // label of the first part whose name has no number

/// Converts labels from the order of the file to the vertices of the mesh.
Labels toVertices(const MeshFile& file, const Labels& of_file, ScanInput& out) {
  Labels labels(file.mesh.positions.size(), -1);
  std::size_t clashes = 0;
  for (std::size_t i = 0; i < of_file.size(); ++i) {
    const std::uint32_t v = file.vertex_of_file[i];
    if (v == kNone) continue;
    if (labels[v] < 0) labels[v] = of_file[i];
    clashes += labels[v] != of_file[i];
  }
  if (clashes > 0)
    out.notes.push_back(std::to_string(clashes) + " vertices lie where another vertex with a different label is; the first label is used.");
  return labels;
}

/// A vertex gets the label with the largest area around it.
Labels fromTriangles(const TriangleMesh& mesh, const Labels& of_triangle) {
  std::vector<std::map<std::int32_t, double>> area(mesh.positions.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double a = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
    for (const std::uint32_t v : mesh.triangles[t]) area[v][of_triangle[t]] += a;
  }
  Labels labels;
  for (const auto& by_label : area) {
    std::int32_t best = 0;
    double largest = -1;
    for (const auto& [label, a] : by_label)
      if (a > largest) largest = a, best = label;
    labels.push_back(best);
  }
  return labels;
}

/// The number of edges between different labels.
std::size_t borderLength(const TriangleMesh& mesh, const Labels& labels) {
  std::size_t sum = 0;
  for (const Triangle& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) sum += labels[t[k]] != labels[t[(k + 1) % 3]];
  return sum;
}

/// Labels for the corners of an STL after a program joined those at one place: in the order in which they first appear,
/// or sorted by their coordinates. Of these orders the right one has the shortest borders between labels by far.
std::optional<Labels> ofJoinedCorners(const TriangleMesh& mesh, const Labels& given, ScanInput& out) {
  constexpr std::size_t kLargestBorder = 5;  // one in so many edges: with vertices in a wrong order nearly all are borders
  constexpr std::array<std::array<int, 3>, 6> kOrders{{{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  Labels best = given;
  std::string order = "their first places in the file";
  std::size_t shortest = borderLength(mesh, best);
  for (const auto& axes : kOrders) {
    std::vector<std::uint32_t> sorted(mesh.positions.size());
    std::iota(sorted.begin(), sorted.end(), 0u);
    std::stable_sort(sorted.begin(), sorted.end(), [&](std::uint32_t a, std::uint32_t b) {
      for (const int axis : axes)
        if (mesh.positions[a][axis] != mesh.positions[b][axis]) return mesh.positions[a][axis] < mesh.positions[b][axis];
      return false;
    });
    Labels labels(given.size());
    for (std::size_t i = 0; i < sorted.size(); ++i) labels[sorted[i]] = given[i];
    const std::size_t border = borderLength(mesh, labels);
    if (border >= shortest) continue;
    shortest = border;
    best = std::move(labels);
    order = {"xyz"[axes[0]], ',', ' ', "xyz"[axes[1]], ',', ' ', "xyz"[axes[2]]};
  }
  if (shortest * kLargestBorder > 3 * mesh.triangles.size()) return std::nullopt;
  out.notes.push_back("the labels are taken for the " + std::to_string(given.size()) +
                      " vertices that joined corners make, in the order of " + order + ".");
  return best;
}

/// Labels in the order of the file, one for each vertex or one for each face.
Labels fromList(const MeshFile& file, const Labels& given, const std::string& side, const std::string& name, ScanInput& out) {
  const std::size_t vertices = file.vertex_of_file.size(), joined = file.mesh.positions.size();
  const bool may_be_vertices = side != "faces", may_be_faces = side != "vertices";
  if (may_be_vertices && given.size() == vertices) return toVertices(file, given, out);
  if (may_be_faces && given.size() == file.faces) {
    out.notes.push_back("the labels are taken for the " + std::to_string(given.size()) + " faces.");
    Labels of_triangle;
    for (const std::uint32_t face : file.face_of_triangle) of_triangle.push_back(given[face]);
    return fromTriangles(file.mesh, of_triangle);
  }
  if (may_be_vertices && given.size() == joined)
    if (std::optional<Labels> labels = ofJoinedCorners(file.mesh, given, out)) return *labels;
  throw FormatError(name + ": has " + std::to_string(given.size()) + " labels, and the scan has " + std::to_string(vertices) +
                    " vertices (" + std::to_string(joined) + " where those at one place are joined) and " + std::to_string(file.faces) +
                    " faces. Give the file for which the labels were made, with its order of vertices.");
}

Labels ofColours(const std::vector<double>& values, const std::string& name) {
  std::map<double, std::size_t> count;
  for (const double v : values) ++count[v];
  if (count.size() > kMaxColours)
    throw FormatError(name + ": has " + std::to_string(count.size()) + " different colours, too many for labels. Name a scalar property.");
  const auto gum = std::max_element(count.begin(), count.end(), [](const auto& a, const auto& b) { return a.second < b.second; })->first;
  std::map<double, std::int32_t> label_of;
  for (const auto& [colour, unused] : count)
    if (colour != gum) label_of.emplace(colour, kFirstUnnumbered + static_cast<std::int32_t>(label_of.size()));
  label_of.emplace(gum, 0);
  Labels labels;
  for (const double v : values) labels.push_back(label_of.at(v));
  return labels;
}

Labels ofNumbers(const std::vector<double>& values, const std::string& name, const std::string& property, bool is_of_faces) {
  Labels labels;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double v = values[i];
    if (!(v >= 0 && v <= formats::kMaxScanLabel && v == std::floor(v)))
      throw FormatError(name + ": the " + property + " of " + (is_of_faces ? "face " : "vertex ") + std::to_string(i) + " is " +
                        std::to_string(v) + ", not a whole number from 0 to " + std::to_string(formats::kMaxScanLabel) + ".");
    labels.push_back(static_cast<std::int32_t>(v));
  }
  return labels;
}

/// Vertices and faces may both have the property: one of them often has a single value, or those of a photo.
const formats::PlyColumn& chosenColumn(const std::vector<formats::PlyColumn>& columns, const std::string& side, const std::string& property,
                                       ScanInput& out) {
  const auto variety = [](const formats::PlyColumn& column) {
    const std::size_t count = std::set<double>(column.values.begin(), column.values.end()).size();
    return count > kMaxColours ? 0 : count;  // no labels
  };
  const formats::PlyColumn* best = nullptr;
  for (const formats::PlyColumn& column : columns) {
    if (side != "auto" && column.is_of_faces != (side == "faces")) continue;
    if (!best || variety(column) > variety(*best)) best = &column;
  }
  if (!best) throw tool::UsageError("--label-side " + side + ": the " + side + " have no property " + property + ". Leave the option out.");
  if (columns.size() > 1)
    out.notes.push_back("the " + property + " of the " + (best->is_of_faces ? "faces" : "vertices") + " is taken, with " +
                        std::to_string(std::set<double>(best->values.begin(), best->values.end()).size()) +
                        " different values; --label-side chooses the other one.");
  return *best;
}

Labels fromProperty(const std::filesystem::path& scan, const MeshFile& file, const LabelSource& source, ScanInput& out) {
  const std::string name = formats::shownName(scan);
  const std::string& property = source.property;
  if (!file.format.starts_with("PLY"))
    throw FormatError(name + ": is " + file.format + "; only PLY has properties. Give the labels as a JSON file, or by --parts.");
  const std::vector<std::byte> bytes = formats::readFile(scan);
  const std::vector<formats::PlyColumn> columns =
      formats::readPlyColumns({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, name, property);
  const formats::PlyColumn& column = chosenColumn(columns, source.side, property, out);
  const bool is_colour = property == "colour" || property == "color";
  if (is_colour)
    out.notes.push_back("colours do not number teeth: the most frequent one is taken as gum, the others are numbered from 101.");
  const Labels labels = is_colour ? ofColours(column.values, name) : ofNumbers(column.values, name, property, column.is_of_faces);
  if (!column.is_of_faces) return toVertices(file, labels, out);
  Labels of_triangle;
  for (const std::uint32_t face : file.face_of_triangle) of_triangle.push_back(labels[face]);
  return fromTriangles(file.mesh, of_triangle);
}

/// Parts without any border are solids, such as those of an atlas: there is nothing to cut.
void refuseClosed(const TriangleMesh& mesh, const Labels& of_part, const std::string& name) {
  std::set<std::array<std::uint32_t, 3>> open;  // part and sides that have no opposite yet
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      if (open.erase({mesh.part[t], b, a}) == 0) open.insert({mesh.part[t], a, b});
    }
  std::set<std::uint32_t> open_parts;
  for (const auto& [part, a, b] : open) open_parts.insert(part);
  std::size_t teeth = 0, closed = 0;
  for (std::uint32_t part = 0; part < of_part.size(); ++part)
    if (of_part[part] != 0) ++teeth, closed += !open_parts.contains(part);
  if (teeth > 0 && 2 * closed > teeth)
    throw FormatError(name + ": " + std::to_string(closed) + " of " + std::to_string(teeth) +
                      " teeth are closed solids already, not a scan to be cut. Make a scene of them: spheretree scene " + name +
                      " -o mouth.scene.json.");
}

Labels fromParts(const std::filesystem::path& scan, const MeshFile& file, const std::string& numbering, ScanInput& out) {
  const TriangleMesh& mesh = file.mesh;
  if (mesh.part_names.size() < 2)
    throw FormatError(formats::shownName(scan) +
                      ": has only one part, so that its parts cannot be labels. Give --labels or --label-property.");
  Labels of_part;
  std::int32_t unnumbered = kFirstUnnumbered;
  for (const std::string& name : mesh.part_names) {
    const std::optional<std::int32_t> number = name.empty() ? std::optional<std::int32_t>(0) : labelOfName(name, numbering);
    of_part.push_back(number ? *number : unnumbered);
    if (number) continue;
    out.notes.push_back("the part " + name + " has no number of a tooth in its name and is called label_" + std::to_string(unnumbered) +
                        ".");
    ++unnumbered;
    if (unnumbered > formats::kMaxScanLabel) throw FormatError(formats::shownName(scan) + ": has too many parts without a number.");
  }
  refuseClosed(mesh, of_part, formats::shownName(scan));
  Labels of_triangle;
  for (const std::uint32_t part : mesh.part) of_triangle.push_back(of_part[part]);
  return fromTriangles(mesh, of_triangle);
}

/// The spread of points about their mean [mm]: about 5 for a molar, over 15 for the gum of a whole jaw.
double spreadOf(const TriangleMesh& mesh, const Labels& labels, std::int32_t label) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double squares = 0, count = 0;
  for (std::size_t v = 0; v < labels.size(); ++v)
    if (labels[v] == label) sum += mesh.positions[v], squares += mesh.positions[v].squaredNorm(), ++count;
  return count > 0 ? std::sqrt(std::max(0.0, squares / count - (sum / count).squaredNorm())) : 0;
}

/// Doubts a tooth that reaches along the arch: some programs give the gum a number of its own.
void judgeSpread(const std::string& name, ScanInput& out) {
  constexpr double kWidestTooth = 9;  // spread of a tooth, above that of any molar, below that of a gum with three teeth [mm]
  const std::set<std::int32_t> found(out.labels.begin(), out.labels.end());
  for (const std::int32_t label : found) {
    const double spread = label == 0 ? 0 : spreadOf(out.mesh, out.labels, label);
    if (spread < kWidestTooth || found.size() < 2) continue;
    char text[200];
    std::snprintf(text, sizeof text, "label %d reaches along the arch, %.0f mm about its middle on average, which no tooth does", label,
                  spread);
    if (!found.contains(0))
      throw FormatError(name + ": " + text + ", and no label is 0. If it is the gum, add --gum-label " + std::to_string(label) + ".");
    out.notes.push_back(text + std::string(". If it is gum, add --gum-label ") + std::to_string(label) + ".");
  }
}

/// Teeth that are absent between those of one side, or that the other side has. Wisdom teeth are not expected.
std::string missingTeeth(const std::set<std::int32_t>& found, const std::string& jaw) {
  std::array<std::set<int>, 2> places;  // right and left, permanent or deciduous
  for (const std::int32_t label : found)
    if (isFdi(label) && isUpperFdi(label) == (jaw == "upper")) {
      const int quadrant = (label / 10 - 1) % 4;
      places[quadrant == 0 || quadrant == 3 ? 0 : 1].insert(label % 10);
    }
  if (places[0].empty() || places[1].empty()) return {};  // a scan of one side
  const int last = std::min(7, std::max(*places[0].rbegin(), *places[1].rbegin()));
  std::string missing;
  for (std::size_t side = 0; side < 2; ++side)
    for (int place = last; place >= 1; --place)
      if (!places[side].contains(place))
        missing +=
            (missing.empty() ? "" : ", ") + std::to_string(10 * (jaw == "upper" ? (side == 0 ? 1 : 2) : (side == 0 ? 4 : 3)) + place);
  return missing;
}

/// Determines the jaw from the labels, and notes on unusual labels.
void judgeLabels(ScanInput& out, const std::string& jaw) {
  if (jaw != "auto") out.jaw = jaw;
  std::set<std::int32_t> found(out.labels.begin(), out.labels.end());
  std::size_t upper = 0, lower = 0;
  std::string odd;
  for (const std::int32_t label : found) {
    if (label == 0) continue;
    if (isFdi(label))
      ++(isUpperFdi(label) ? upper : lower);
    else
      odd += (odd.empty() ? "" : ", ") + std::to_string(label);
  }
  if (!odd.empty()) out.notes.push_back("labels that are not FDI numbers of teeth: " + odd + "; they become parts called label_N.");
  if (out.jaw.empty() && upper + lower > 0) out.jaw = upper >= lower ? "upper" : "lower";
  std::string strangers;
  for (const std::int32_t label : found)
    if (isFdi(label) && !out.jaw.empty() && isUpperFdi(label) != (out.jaw == "upper"))
      strangers += (strangers.empty() ? "" : ", ") + std::to_string(label);
  if (!strangers.empty()) out.notes.push_back("numbers of the other jaw in a scan of the " + out.jaw + " one: " + strangers + ".");
  if (const std::string missing = missingTeeth(found, out.jaw); !missing.empty()) out.notes.push_back("missing teeth: " + missing + ".");
}

}  // namespace

ScanInput readScan(const std::filesystem::path& scan, const std::string& unit, const LabelSource& source, const std::string& jaw) {
  MeshFile file = readMeshIn(scan, unit);
  ScanInput out;
  if (!source.file.empty()) {
    const formats::ScanLabels labels = formats::readScanLabels(source.file);
    out.labels = fromList(file, labels.labels, source.side, source.file.string(), out);
    out.jaw = labels.jaw;
  } else if (!source.property.empty()) {
    out.labels = fromProperty(scan, file, source, out);
  } else {
    out.labels = fromParts(scan, file, source.numbering, out);
  }
  if (source.numbering == "palmer" && !source.parts)
    throw tool::UsageError("Palmer notation has letters, so it can only stand in names of parts. Use --parts, or --numbering fdi.");
  if (source.gum_label) {
    if (std::find(out.labels.begin(), out.labels.end(), *source.gum_label) == out.labels.end())
      throw FormatError(formats::shownName(scan) + ": no label is " + std::to_string(*source.gum_label) + ", as --gum-label says.");
    std::replace(out.labels.begin(), out.labels.end(), *source.gum_label, 0);
  }
  if (source.numbering == "universal" && !source.parts)
    for (std::int32_t& label : out.labels)
      if (label != 0) label = fdiOfUniversal(label).value_or(label + 100);  // not a tooth, and not the number of one
  for (std::int32_t& label : out.labels) label = std::max(label, 0);
  out.space = file.space;
  file.mesh.part.clear();
  file.mesh.part_names.clear();
  out.mesh = std::move(file.mesh);
  judgeSpread(formats::shownName(scan), out);
  judgeLabels(out, jaw);
  return out;
}

}  // namespace spheretree::pipeline
