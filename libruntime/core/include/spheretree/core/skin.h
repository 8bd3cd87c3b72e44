// SPDX-License-Identifier: Apache-2.0
// The skin of an object: the surface that a tool rests on. It is a mesh of triangles with two uses. The flat triangles
// carry the *guarantee*: no leaf of a tool gets deeper into them than the skin's tolerance. Smooth patches, one over
// each triangle, carry what is *felt*: their normal is continuous from patch to patch, except across sharp edges. How
// the builder makes them and proves their distance from the mesh: docs/algorithms/skin/skin.md
//
// A patch is quadratic in the barycentric coordinates w of its triangle. It has six nodes (the three corners, then the
// middles of the sides 01, 12 and 20), each with a position p_i and a normal n_i:
//     position(w) = sum_i L_i(w) p_i,    normal(w) = sum_i L_i(w) n_i (not of unit length),
// where L_i are the quadratic Lagrange polynomials w_0 (2 w_0 - 1), ..., 4 w_0 w_1, ... Neighbours share the nodes of a
// side, so that positions and normals agree along it; along a sharp edge only the positions agree.
// Positions are stored as 21-bit integers in a box, normals as octahedral coordinates: 12 bytes a vertex, 8 an edge, 12
// a triangle.
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

/// A unit vector in octahedral coordinates.
/// Paper: Q. Meyer et al. On floating-point normal vectors. Computer Graphics Forum 29(4), 2010.
using PackedNormal = std::array<std::int16_t, 2>;

/// Largest angle between a direction and its packed form [rad]. Rounding moves each coordinate by at most 0.5 / 32767,
/// and a point of the octahedron by at most sqrt(6) of that. A direction turns most at the middle of a face, where the
/// octahedron is nearest to its centre: by sqrt(3) of that, 6.5e-5.
inline constexpr double kNormalError = 6.6e-5;

inline constexpr std::uint32_t kMaxSkinCoordinate = (1u << 21) - 1;  // three of them fit 64 bits

using SkinPosition = std::array<std::uint32_t, 3>;  // from Skin::low, in units of Skin::step; at most kMaxSkinCoordinate

struct SkinVertex {
  SkinPosition position;
  PackedNormal normal;
};

struct SkinEdge {
  std::array<std::int8_t, 3> offset;  // from the middle of the chord to the middle of the edge, in units of Skin::offset_step
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
  float tolerance = 0;         // proven: no point of a patch is farther than this from its flat triangle [mm]
  float mesh_distance = 0;     // proven: two-sided distance of the flat triangles and the mesh is at most this [mm]
  float crease_angle = 0;      // edges with a larger angle are sharp [rad]
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

/// The nodes of a patch with a fourth component that is 0: one instruction takes all of a node.
struct PaddedPatch {
  std::array<Eigen::Vector4f, 6> position, normal;
};
PaddedPatch padded(const SkinPatch& patch);

/// Where a vertex with this packed position is [mm].
Eigen::Vector3f positionOf(const Skin& skin, const SkinPosition& steps);

/// Cost: about 60 ns. `triangle` must be in range and the skin sound (findFault).
SkinPatch patchOf(const Skin& skin, std::size_t triangle);

struct SkinNode {
  Eigen::Vector3f position;  // of a vertex; for an edge: from the middle of its chord to its middle
  Eigen::Vector3f normal;
};

SkinNode nodeOf(const Skin& skin, const SkinVertex& vertex);
SkinNode nodeOf(const Skin& skin, const SkinEdge& edge);

/// The nodes of a whole skin, each unpacked once.
class SkinNodes {
 public:
  /// `skin` must be sound.
  explicit SkinNodes(const Skin& skin);
  std::span<const SkinNode> ofVertices() const { return vertices_; }
  std::span<const SkinNode> ofEdges() const { return edges_; }

 private:
  std::vector<SkinNode> vertices_, edges_;
};

/// How far an edge bends its patches outward: 4/3 of its offset, rounded up [mm]. A patch is its flat triangle plus
/// sum_e 4 w_a w_b offset_e over its sides e = ab. The three products w_a w_b add up to at most 1/3, so no point of the
/// patch moves farther than the largest swing of its three sides.
float swingOf(const Skin& skin, const SkinEdge& edge);

/// The depth below the flat triangle of `patch` at which the guarantee of the skin is broken: 0 for a flat patch (no
/// offsets, and the same normal at all six nodes, up to packing), else `tolerance` [mm].
float allowanceOf(const SkinPatch& patch, float tolerance);
bool isFlat(const PaddedPatch& patch);

PackedNormal packNormal(const Eigen::Vector3d& unit);
Eigen::Vector3f unpackNormal(const PackedNormal& normal);

/// A sphere that encloses both the flat triangle and the patch. Deterministic. Cost: about 50 ns.
Sphere enclose(const PaddedPatch& patch);
Sphere enclose(const SkinPatch& patch);

/// Returns a sentence about the first broken rule, which names the element, or "" for a sound skin. The rules: indices
/// are in range; numbers are finite and in range; no edge swings out farther than the tolerance; every sphere of the
/// search tree encloses the corners and control points of the patches below it. The hull of these six points contains
/// the patch and its flat triangle. The control point of a side from a to b with the middle m is 2 m - (a + b) / 2.
/// Cost: about 50 ns a triangle.
std::string findFault(const Skin& skin);

}  // namespace spheretree
