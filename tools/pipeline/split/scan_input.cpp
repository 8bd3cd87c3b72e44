// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/split/scan_input.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
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
    if (v == kNoVertex) continue;
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

std::string sizesDiffer(std::size_t labels, std::size_t elements, const std::string& what) {
  return std::to_string(labels) + " labels for " + std::to_string(elements) + " " + what +
         ". Give the file for which the labels were made, with its order of vertices.";
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

Labels fromProperty(const std::filesystem::path& scan, const MeshFile& file, const std::string& property, ScanInput& out) {
  const std::string name = formats::shownName(scan);
  if (!file.format.starts_with("PLY"))
    throw FormatError(name + ": is " + file.format + "; only PLY has properties. Give the labels as a JSON file, or by --parts.");
  const std::vector<std::byte> bytes = formats::readFile(scan);
  const formats::PlyColumn column = formats::readPlyColumn({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, name, property);
  const bool is_colour = property == "colour" || property == "color";
  if (is_colour)
    out.notes.push_back("colours do not number teeth: the most frequent one is taken as gum, the others are numbered from 101.");
  const Labels labels = is_colour ? ofColours(column.values, name) : ofNumbers(column.values, name, property, column.is_of_faces);
  if (!column.is_of_faces) return toVertices(file, labels, out);
  if (labels.size() != file.mesh.triangles.size())
    throw FormatError(name + ": has faces other than triangles, whose labels cannot be assigned. Export it as triangles.");
  return fromTriangles(file.mesh, labels);
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
  Labels of_triangle;
  for (const std::uint32_t part : mesh.part) of_triangle.push_back(of_part[part]);
  return fromTriangles(mesh, of_triangle);
}

/// Determines the jaw from the labels, and notes on unusual labels.
void judgeLabels(ScanInput& out) {
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
}

}  // namespace

ScanInput readScan(const std::filesystem::path& scan, const std::string& unit, const LabelSource& source) {
  MeshFile file = readMeshIn(scan, unit);
  ScanInput out;
  if (!source.file.empty()) {
    const formats::ScanLabels labels = formats::readScanLabels(source.file);
    if (labels.labels.size() != file.vertex_of_file.size())
      throw FormatError(source.file.string() + ": " +
                        sizesDiffer(labels.labels.size(), file.vertex_of_file.size(), "vertices of " + formats::shownName(scan)));
    out.labels = toVertices(file, labels.labels, out);
    out.jaw = labels.jaw;
  } else if (!source.property.empty()) {
    out.labels = fromProperty(scan, file, source.property, out);
  } else {
    out.labels = fromParts(scan, file, source.numbering, out);
  }
  if (source.numbering == "palmer" && !source.parts)
    throw tool::UsageError("Palmer notation has letters, so it can only stand in names of parts. Use --parts, or --numbering fdi.");
  if (source.numbering == "universal" && !source.parts)
    for (std::int32_t& label : out.labels)
      if (label != 0) label = fdiOfUniversal(label).value_or(label + 100);  // not a tooth, and not the number of one
  for (std::int32_t& label : out.labels) label = std::max(label, 0);
  judgeLabels(out);
  file.mesh.part.clear();
  file.mesh.part_names.clear();
  out.mesh = std::move(file.mesh);
  return out;
}

}  // namespace spheretree::pipeline
