// SPDX-License-Identifier: GPL-3.0-or-later
// The text of a report, and the changes to a mesh that it permits.
#include <algorithm>
#include <cstdio>
#include <utility>

#include "spheretree/builder/mesh_checks.h"
#include "spheretree/core/mesh_edit.h"

namespace spheretree::builder {
namespace {

std::string numberText(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string pointText(const Eigen::Vector3d& p) {
  std::string text = "(";
  text.append(numberText(p.x())).append(", ").append(numberText(p.y())).append(", ").append(numberText(p.z()));
  return text.append(")");
}

std::string counted(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

struct Wording {
  const char *one, *many;  // name of what is counted, singular and plural
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
      return {"component", "components", "A build reverses it; so does \"flip normals\"."};
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

TriangleMesh orientOutward(TriangleMesh mesh, const MeshReport& report) {
  for (std::size_t t = 0; t < mesh.triangles.size() && t < report.component_of.size(); ++t)
    if (report.components[report.component_of[t]].inside_out) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  return mesh;
}

TriangleMesh withoutBuried(const TriangleMesh& mesh, const MeshReport& report) {
  if (report.buriedComponents() == 0) return mesh;
  TriangleMesh result;
  result.positions = mesh.positions;
  result.part_names = mesh.part_names;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (report.components[report.component_of[t]].buried) continue;
    result.triangles.push_back(mesh.triangles[t]);
    if (!mesh.part.empty()) result.part.push_back(mesh.part[t]);
  }
  dropUnusedVertices(result);
  return result;
}

}  // namespace spheretree::builder
