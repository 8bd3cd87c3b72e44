// SPDX-License-Identifier: GPL-3.0-or-later
// Finds the defects of a mesh and their places. The builders need closed, manifold surfaces, wound outward and free of
// self-intersections, because only these determine inside and outside. The kinds of defects, and what to do about each:
// docs/mesh_input.md
// Units: mm. Deterministic: same mesh, same report.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

enum class DefectKind {
  NoTriangles,
  BadIndex,           // a triangle names a vertex that does not exist
  NonFinite,          // a coordinate is NaN or infinite
  Scale,              // too large or too small for float32 and its squares: most likely a wrong unit
  DegenerateFace,     // corners repeated or exactly in line
  DuplicateFace,      // same corners as an earlier triangle, in any order
  NonManifoldEdge,    // of three triangles or more
  NonManifoldVertex,  // two or more fans of triangles meet only in this vertex
  ClashingWinding,    // two triangles traverse their common edge in the same direction
  Border,             // an edge of one triangle only
  NoVolume,           // a closed component that encloses no volume in double precision
  InsideOut,          // a closed component, not a cavity, that is wound inward; orientOutward turns it
  SelfIntersection    // two triangles cross, touch or overlap outside shared corners; exact
};

/// For example "non-manifold edge"; reports and JSON keys have '_' in place of blanks and hyphens.
std::string_view name(DefectKind kind);

inline constexpr std::size_t kPlacesListed = 5;            // of each defect, unless the caller wants more
inline constexpr std::size_t kMaxCrossingPairs = 100'000;  // the search for self-intersections stops at this number

struct Place {
  std::vector<std::uint32_t> triangles;  // one, or the two of a pair, from 0
  std::vector<std::uint32_t> vertices;   // one, or the two of an edge, from 0; may be empty
  Eigen::Vector3d point;                 // vertex, middle of the edge or of the triangle [mm]
};

struct Defect {
  DefectKind kind;
  std::size_t count = 0;        // of triangles, edges, vertices, components or pairs
  bool is_lower_bound = false;  // there may be more: the search was stopped
  std::vector<Place> first;     // the first ones in the order of the mesh, as many as the caller wants
};

/// Border edges connected with each other: usually one hole.
struct Hole {
  std::size_t edges = 0;
  double length = 0;  // of its edges [mm]
  Place first;
};

/// Triangles connected by edges.
struct Component {
  std::size_t triangles = 0;
  std::uint32_t first_triangle = 0;
  double volume = 0;        // signed, as wound in the mesh [mm^3]; 0 if it is not closed
  bool inside_out = false;  // orientOutward turns it
  bool buried = false;      // lies wholly within solid matter: it bounds nothing
  bool cavity = false;      // a correct cavity: wound inward, within solid matter
};

struct MeshReport {
  std::size_t triangles = 0, vertices = 0;
  double volume = 0;  // signed sum over all triangles, about the centre of the box; meaningful only for a closed mesh [mm^3]
  double area = 0;    // [mm^2]
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();  // box of the vertices in use [mm]
  std::vector<Defect> defects;                                                    // in the order of DefectKind
  std::vector<Hole> holes;                                                        // longest first
  std::vector<Component> components;                                              // by first triangle
  std::vector<std::uint32_t> component_of;  // for each triangle; empty if the mesh could not be searched
  std::vector<std::string> not_checked;     // checks that earlier defects make meaningless; whole sentences

  bool clean() const { return defects.empty(); }
  /// True if there are no defects but those that orientOutward corrects.
  bool fixable() const { return defects.empty() || (defects.size() == 1 && defects[0].kind == DefectKind::InsideOut); }
  bool has(DefectKind kind) const;
  std::size_t count(DefectKind kind) const;  // 0 if there is none
  std::size_t buriedComponents() const;

  /// One line for each defect: kind, count, first place, what to do. Then the checks that were not made. Empty if there
  /// is nothing to report.
  std::string summary() const;
};

/// `places`: how many places to list for each defect. Cost: O(n log n) plus one test for each pair of triangles whose
/// boxes overlap; about 0.5 s for 100,000 triangles. Throws nothing but std::bad_alloc and Cancelled, whatever the
/// mesh.
MeshReport checkMesh(const TriangleMesh& mesh, std::size_t places = kPlacesListed, const Progress& progress = {});

/// Turns the components that `report` of this mesh marks as inside out.
TriangleMesh orientOutward(TriangleMesh mesh, const MeshReport& report);

/// Removes the components that `report` of this mesh marks as buried, and the vertices that only they use.
TriangleMesh withoutBuried(const TriangleMesh& mesh, const MeshReport& report);

}  // namespace spheretree::builder
