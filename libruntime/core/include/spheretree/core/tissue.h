// SPDX-License-Identifier: Apache-2.0
// Soft tissue: tetrahedra that carry the surface of an object, and with it the leaves of its sphere-tree.
//
// The surface of the mesh is bound to the tetrahedra: a vertex moves as the affine map of its tetrahedron says,
//     x = x_rest + sum_k w_k u_k,    u_k: displacement of corner k, w_k: barycentric weights, which add up to 1.
// The deformed object is the mesh with its vertices at these places.
//
// Certificate. Every triangle of the mesh is cut into convex pieces, each of one leaf. The map of a triangle is affine,
// so the image of a piece is the hull of the images of its corners; and a ball is convex. Therefore a leaf with the
// moved centre c' and the radius r' = max |x - c'| over the corners x of its pieces, rounded outward, holds the images
// of its pieces in every state of the nodes, tetrahedra inside out included. How it is made: docs/tissue.md
// Units: mm, kPa, kg/m^3. Frame of the tree.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "spheretree/core/sphere_tree.h"

namespace spheretree {

inline constexpr double kMinYoungKpa = 0.1, kMaxYoungKpa = 100'000;  // softer than any tissue; tendon and ligament reach 100 MPa
inline constexpr double kMaxPoisson = 0.495;                    // nearer to 0.5 the stiffness matrix loses the digits that the result needs
inline constexpr double kMinDensity = 100, kMaxDensity = 5000;  // [kg/m^3]
inline constexpr std::uint32_t kMaxTissueNodes = 1u << 20;

/// Tetrahedra as whoever made them gives them; nothing about them is trusted. Frame of the mesh [mm].
struct TetrahedronList {
  std::vector<Eigen::Vector3d> nodes;
  std::vector<std::array<std::uint32_t, 4>> corners;
};

/// Isotropic linear elasticity, the same everywhere in the object.
struct TissueMaterial {
  double young_kpa = 0;      // Young's modulus; kMinYoungKpa .. kMaxYoungKpa
  double poisson = 0;        // 0 .. kMaxPoisson
  double density_kg_m3 = 0;  // kMinDensity .. kMaxDensity
  friend bool operator==(const TissueMaterial&, const TissueMaterial&) = default;
};

/// A vertex of the mesh. It may lie a little outside of its tetrahedron: weights below 0 or above 1.
struct TissueVertex {
  std::array<double, 3> rest;  // [mm]
  std::uint32_t tetrahedron;
  std::array<float, 3> weight;  // of corners 0, 1, 2; that of corner 3 is what is left of 1
};
static_assert(sizeof(TissueVertex) == 40);

/// A corner of a piece that is no vertex of the mesh: a point of a triangle.
struct TissueCut {
  std::array<std::uint32_t, 3> vertex;  // the corners of the triangle
  std::uint32_t reserved = 0;
  std::array<double, 2> weight;  // of corners 1 and 2; that of corner 0 is what is left of 1
};
static_assert(sizeof(TissueCut) == 32);

/// Where the centre of a leaf is: at `depth` from a point of a triangle, in a direction that turns as a normal of
/// `tetrahedron` does. So a leaf keeps its distance from the surface where the inside is squeezed.
struct LeafAnchor {
  std::array<std::uint32_t, 3> vertex;  // the corners of the triangle
  std::array<float, 2> weight;          // of the point: of corners 1 and 2
  std::uint32_t tetrahedron;
  std::array<float, 3> direction;  // times the edges of the tetrahedron at rest: its dot products with (b - a), (c - a), (d - a)
  float depth;                     // [mm], >= 0
};
static_assert(sizeof(LeafAnchor) == 40);

/// The leaves of the tree in the order of levelSet() of its deepest level, and the pieces of the surface that each
/// holds.
struct TissueLeaves {
  std::vector<LeafAnchor> anchors;     // (leaves)
  std::vector<std::uint32_t> begin;    // (leaves + 1) where the corners of a leaf's pieces begin in `corners`
  std::vector<std::uint32_t> corners;  // below the number of vertices: a vertex; from there on: a cut
  std::vector<TissueCut> cuts;
};

/// A point of a triangle of the tetrahedra's surface.
inline constexpr std::uint32_t kHeldNode = 0xffffffff;  // a node that stays where it is
struct PressPoint {
  std::array<std::uint32_t, 3> node;  // indices into TissueResponse::pressed, or kHeldNode
  std::array<float, 3> weight;        // >= 0; they add up to 1

  /// Of the point, when the pressed nodes move by `nodes`: x, y, z of each.
  Eigen::Vector3d displacementIn(std::span<const float> nodes) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      if (node[k] == kHeldNode) continue;
      const float* const u = nodes.data() + 3 * std::size_t{node[k]};
      sum += static_cast<double>(weight[k]) * Eigen::Vector3d(u[0], u[1], u[2]);
    }
    return sum;
  }
};
static_assert(sizeof(PressPoint) == 24);

/// Small motion: displacements of the surface are linear in the forces on it. `matrix` is the inverse of the stiffness
/// matrix, condensed to the surface: symmetric and positive definite.
struct TissueResponse {
  std::vector<std::uint32_t> pressed;  // nodes of the tetrahedra's surface that can move; ascending
  std::vector<PressPoint> points;      // (vertices of the tree's skin) what each goes with, and where a force on it acts
  std::vector<float> matrix;           // (pressed x 3 axes of the force) x (pressed x 3 axes of the displacement) [mm/N]

  bool empty() const { return pressed.empty(); }
  /// Displacements of the pressed nodes, x, y, z of each, under 1 N along an axis on pressed node `i`.
  std::span<const float> column(std::size_t i, std::size_t axis) const {
    return std::span(matrix).subspan((3 * i + axis) * 3 * pressed.size(), 3 * pressed.size());
  }
};

struct Tissue {
  TissueMaterial material;
  std::vector<std::array<double, 3>> nodes;              // at rest [mm]
  std::vector<std::array<std::uint32_t, 4>> tetrahedra;  // corners; (b - a) x (c - a) . (d - a) > 0
  std::vector<std::uint32_t> fixed;                      // nodes that stay where they are; ascending
  std::vector<TissueVertex> surface;                     // of the mesh that the tree was built from, in its order
  TissueLeaves leaves;
  TissueResponse response;  // may be empty

  bool empty() const { return tetrahedra.empty(); }
  friend bool operator==(const Tissue&, const Tissue&);
};

/// First value of `material` that is out of range, as a sentence that says the range and what is usually mixed up, or
/// "".
std::string findFault(const TissueMaterial& material);

/// First broken rule as a sentence that names the element, or "" for sound tissue: the material, numbers finite,
/// indices in range, `fixed` ascending, tetrahedra of positive volume, the response of the right size. That the
/// pieces of the leaves make up the whole surface is proven by whoever makes them and cannot be seen here. Cost:
/// O(size).
std::string findFault(const Tissue& tissue);

/// The same, and whether the tissue has the leaves of `tree` and moves the vertices of its skin.
std::string findFault(const Tissue& tissue, const SphereTree& tree);

/// The faces of one tetrahedron alone, counter-clockwise seen from outside; always in the same order.
std::vector<std::array<std::uint32_t, 3>> outerFaces(const Tissue& tissue);

/// Where the vertices of the surface are when the nodes have moved by `displacements` (one for each node) [mm].
/// `positions`: one for each vertex. Cost: about 10 ns a vertex.
void moveSurface(const Tissue& tissue, std::span<const Eigen::Vector3d> displacements, std::span<Eigen::Vector3d> positions) noexcept;

/// The leaves when the nodes have moved by `displacements`, from the places that moveSurface() gave: together they hold
/// every point of the moved surface, whatever the state. `leaves`: one for each; no allocation. A leaf without a piece
/// of the surface becomes a point of 1e-6 mm. Where a state is not finite, neither are the leaves.
/// Cost: about 10 ns a corner.
void moveLeaves(const Tissue& tissue, std::span<const Eigen::Vector3d> displacements, std::span<const Eigen::Vector3d> positions,
                std::span<Sphere> leaves) noexcept;

/// `tree` with the leaves `leaves` (as moveLeaves() gives them), every inner node and every node of the search tree
/// around them, and without the skin, which is that of the rest. The cover sphere of an inner node is its bounding
/// sphere, so that every level covers the moved surface. A sound tree (findFault) if the leaves are finite.
SphereTree movedTree(const SphereTree& tree, std::span<const Sphere> leaves);

}  // namespace spheretree
