// SPDX-License-Identifier: GPL-3.0-or-later
// What is wrong with a mesh, and where. The builders need closed, manifold surfaces, wound outward, that do not cross
// themselves: only then is it certain what is inside. Kinds of defects, and what to do about each: docs/mesh_input.md
// Units: mm. Deterministic: same mesh, same report.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

enum class DefectKind {
  NoTriangles,
  BadIndex,           // a triangle names a vertex that does not exist
  NonFinite,          // a coordinate is NaN or infinite
  Scale,              // larger or smaller than float32 and squares of it can hold: most likely a wrong unit
  DegenerateFace,     // corners repeated or exactly in line
  DuplicateFace,      // same corners as an earlier triangle, in any order
  NonManifoldEdge,    // of three triangles or more
  NonManifoldVertex,  // two or more fans of triangles meet in nothing but this vertex
  ClashingWinding,    // an edge of two triangles that run along it in the same direction
  Border,             // an edge of one triangle only
  NoVolume,           // a closed component that encloses nothing, as far as double precision tells
  InsideOut,          // a closed component wound inward that is no cavity; orientOutward turns it
  SelfIntersection    // two triangles cross, touch or overlap outside shared corners; exact
};

/// "non-manifold edge"; in reports and as key of JSON, with '_' in place of blanks and hyphens.
std::string_view name(DefectKind kind);

inline constexpr std::size_t kPlacesListed = 5;            // of each defect, unless more are asked for
inline constexpr std::size_t kMaxCrossingPairs = 100'000;  // the search for self-intersections then stops

struct Place {
  std::vector<std::uint32_t> triangles;  // one, or the two of a pair, from 0
  std::vector<std::uint32_t> vertices;   // one, or the two of an edge, from 0; may be empty
  Eigen::Vector3d point;                 // vertex, middle of the edge or of the triangle [mm]
};

struct Defect {
  DefectKind kind;
  std::size_t count = 0;        // of triangles, edges, vertices, components or pairs
  bool is_lower_bound = false;  // there may be more: the search was stopped
  std::vector<Place> first;     // as many as were asked for, in the order of the mesh
};

/// Border edges that hang together: usually one hole.
struct Hole {
  std::size_t edges = 0;
  double length = 0;  // of its edges [mm]
  Place first;
};

/// Triangles that hang together by edges.
struct Component {
  std::size_t triangles = 0;
  std::uint32_t first_triangle = 0;
  double volume = 0;        // signed, as wound in the mesh [mm^3]; 0 if it is not closed
  bool inside_out = false;  // orientOutward turns it
  bool buried = false;      // lies wholly within solid matter: bounds nothing
  bool cavity = false;      // wound inward within solid matter: a hollow, and as it should be
};

struct MeshReport {
  std::size_t triangles = 0, vertices = 0;
  double volume = 0;  // signed sum over all triangles, about the centre of the box; tells something only of a closed mesh [mm^3]
  double area = 0;    // [mm^2]
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();  // box of the vertices in use [mm]
  std::vector<Defect> defects;                                                    // in the order of DefectKind
  std::vector<Hole> holes;                                                        // longest first
  std::vector<Component> components;                                              // by first triangle
  std::vector<std::uint32_t> component_of;  // for each triangle; empty if the mesh could not be searched
  std::vector<std::string> not_checked;     // checks that earlier defects make meaningless; whole sentences

  bool clean() const { return defects.empty(); }
  /// Nothing but what orientOutward puts right.
  bool fixable() const { return defects.empty() || (defects.size() == 1 && defects[0].kind == DefectKind::InsideOut); }
  bool has(DefectKind kind) const;
  std::size_t count(DefectKind kind) const;  // 0 if there is none
  std::size_t buriedComponents() const;

  /// One line for each defect: kind, count, first place, what to do. Then what was not checked. Empty if there is
  /// nothing to say.
  std::string summary() const;
};

/// `places`: how many to list of each defect. Cost: O(n log n) plus one test for each pair of triangles whose boxes
/// meet; about 0.5 s for 100,000 triangles. Never throws but for want of memory, whatever the mesh.
MeshReport checkMesh(const TriangleMesh& mesh, std::size_t places = kPlacesListed);

/// Turns the components that `report` of this mesh calls inside out.
TriangleMesh orientOutward(TriangleMesh mesh, const MeshReport& report);

/// Leaves out the components that `report` of this mesh calls buried, and the vertices that only they use.
TriangleMesh withoutBuried(const TriangleMesh& mesh, const MeshReport& report);

}  // namespace spheretree::builder
