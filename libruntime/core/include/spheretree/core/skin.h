// SPDX-License-Identifier: Apache-2.0
// The skin of an object: the surface that a tool rests on. A mesh of triangles carries two things. What is *guaranteed*
// are its flat triangles: no leaf of a tool gets deeper into them than the skin's tolerance. What is *felt* are smooth
// patches, one over each triangle, with a normal that is continuous from patch to patch but for sharp edges. How the
// builder makes them and proves how far they lie from the mesh: docs/algorithms/skin/skin.md
//
// A patch is quadratic in the barycentric coordinates w of its triangle: with six nodes (the three corners, then the
// middles of the sides 01, 12 and 20), each with a position p_i and a normal n_i,
//     position(w) = sum_i L_i(w) p_i,    normal(w) = sum_i L_i(w) n_i (not of unit length),
// where L_i are the quadratic Lagrange polynomials w_0 (2 w_0 - 1), ..., 4 w_0 w_1, ... Neighbours share the nodes of a
// side, so that positions and normals agree along it; along a sharp edge only the positions do.
// Positions are stored as whole numbers of 21 bits in a box, normals by octahedral coordinates: 12 bytes a vertex, 8 an
// edge, 12 a triangle.
// Units: mm, frame of the tree.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "spheretree/core/search_tree.h"

namespace spheretree {

/// A unit vector by octahedral coordinates.
/// Paper: Q. Meyer et al. On floating-point normal vectors. Computer Graphics Forum 29(4), 2010.
using PackedNormal = std::array<std::int16_t, 2>;

/// No direction is farther from its packed form [rad]. Rounding moves each coordinate by half of 1/32767 at most, a
/// point of the octahedron by sqrt(6) of that, and the middle of a face, where the octahedron is nearest to its centre,
/// turns by sqrt(3) of that: 6.5e-5.
inline constexpr double kNormalError = 6.6e-5;

inline constexpr std::uint32_t kMaxSkinCoordinate = (1u << 21) - 1;  // three of them fit 64 bits

struct SkinVertex {
  std::array<std::uint32_t, 3> position;  // times Skin::step, from Skin::low; at most kMaxSkinCoordinate
  PackedNormal normal;
};

struct SkinEdge {
  std::array<std::int8_t, 3> offset;  // of the middle from the middle of the chord, times Skin::offset_step
  std::uint8_t is_sharp;              // 1: the surface has a crease or a border here; the edge is then straight (offset 0)
  PackedNormal normal;                // at the middle
};
static_assert(sizeof(SkinEdge) == 8);

struct SkinTriangle {
  std::array<std::uint16_t, 3> vertex;  // counter-clockwise seen from outside
  std::array<std::uint16_t, 3> edge;    // side 01, 12, 20
};
static_assert(sizeof(SkinTriangle) == 12);

struct Skin {
  std::array<float, 3> low{};  // a corner of the box of the vertices [mm]
  float step = 0;              // [mm]
  float offset_step = 0;       // [mm]
  float tolerance = 0;         // no point of a patch is farther from its flat triangle than this; proven [mm]
  float mesh_distance = 0;     // no point of the flat triangles is farther from the mesh, nor of the mesh from them; proven [mm]
  float crease_angle = 0;      // edges sharper than this are sharp [rad]
  std::vector<SkinVertex> vertices;
  std::vector<SkinEdge> edges;
  std::vector<SkinTriangle> triangles;  // in the order of the search tree, whose `item` is empty
  SearchTree search;                    // over the triangles

  bool empty() const { return triangles.empty(); }
  friend bool operator==(const Skin&, const Skin&);
};

/// The nodes of one patch: corners 0, 1, 2, then the middles of the sides 01, 12, 20.
struct SkinPatch {
  std::array<Eigen::Vector3f, 6> position;
  std::array<Eigen::Vector3f, 6> normal;  // of unit length up to rounding
  std::array<bool, 3> is_sharp{};         // (sides)
};

/// Cost: about 60 ns. `triangle` must be in range and the skin sound (findFault).
SkinPatch patchOf(const Skin& skin, std::size_t triangle);

struct SkinNode {
  Eigen::Vector3f position;  // of a vertex; of an edge's middle from the middle of its chord
  Eigen::Vector3f normal;
};

/// The nodes of a whole skin, each unpacked once. patchOf() gives the same as that of the skin, in a third of the time.
class SkinNodes {
 public:
  /// `skin` must be sound and outlive this.
  explicit SkinNodes(const Skin& skin);
  SkinPatch patchOf(std::size_t triangle) const;
  std::span<const SkinNode> ofVertices() const { return vertices_; }
  std::span<const SkinNode> ofEdges() const { return edges_; }

 private:
  const Skin& skin_;
  std::vector<SkinNode> vertices_, edges_;
};

/// How far an edge bends its patches out: 4/3 of its offset, rounded up [mm]. A patch is its flat triangle plus
/// sum_e 4 w_a w_b offset_e over its sides e = ab; since the three products w_a w_b add up to at most 1/3, no point of
/// it moves farther than the largest swing of its three sides.
float swingOf(const Skin& skin, const SkinEdge& edge);

/// How much deeper than the flat triangle of `patch` a tool may get before the guarantee of the skin is broken: 0 for a
/// flat patch (no offsets, and the same normal at all six nodes, up to packing), else `tolerance` [mm].
float allowanceOf(const SkinPatch& patch, float tolerance);

PackedNormal packNormal(const Eigen::Vector3d& unit);
Eigen::Vector3f unpackNormal(const PackedNormal& normal);

/// A sphere that encloses the flat triangle and the patch. Deterministic. Cost: about 50 ns.
Sphere enclose(const SkinPatch& patch);

/// First broken rule as a sentence that names the element, or "" for a sound skin: indices in range, numbers finite and
/// in range, no edge swings out farther than the tolerance, and every sphere of the search tree encloses the corners
/// and the control points of the patches below it. The hull of these six points holds the patch and its flat triangle;
/// the control point of a side from a to b with the middle m is 2 m - (a + b) / 2. Cost: about 50 ns a triangle.
std::string findFault(const Skin& skin);

}  // namespace spheretree
