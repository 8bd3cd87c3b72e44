// SPDX-License-Identifier: Apache-2.0
// Soft tissue: tetrahedra that move the surface of an object, and with it the leaves of its sphere-tree.
//
// The surface of the mesh is bound to the tetrahedra: each vertex moves with the affine map of its tetrahedron,
//     x = x_rest + sum_k w_k u_k,    u_k: displacement of corner k, w_k: barycentric weights, which add up to 1.
// The deformed object is the mesh with its vertices at these positions.
//
// Certificate. Every triangle of the mesh is cut into convex pieces, each of which belongs to one leaf. The map of a
// triangle is affine, so the image of a piece is the hull of the images of its corners; and a ball is convex. Therefore
// a leaf with the moved centre c' and the radius r' = max |x - c'| over the corners x of its pieces, rounded outward,
// contains the images of its pieces for all displacements of the nodes, even if tetrahedra are inverted. How it is
// made: docs/tissue.md
// Units: mm, kPa, kg/m^3. Frame of the tree.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "spheretree/core/none.h"
#include "spheretree/core/sphere_tree.h"

namespace spheretree {

inline constexpr double kMinYoungKpa = 0.1,
                        kMaxYoungKpa = 100'000;  // the minimum is softer than any tissue; tendon and ligament reach 100 MPa
inline constexpr double kMaxPoisson = 0.495;  // nearer to 0.5 the stiffness matrix is so ill-conditioned that the result loses its digits
inline constexpr double kMinDensity = 100, kMaxDensity = 5000;  // [kg/m^3]
inline constexpr std::uint32_t kMaxTissueNodes = 1u << 20;

/// The faces of a tetrahedron of positive volume, opposite each corner, counter-clockwise seen from outside.
inline constexpr std::array<std::array<std::size_t, 3>, 4> kTetrahedronFaces{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// Tetrahedra as they come from a mesher or a file, not yet checked. Frame of the mesh [mm].
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
  std::array<float, 3> weight;  // of corners 0, 1, 2; that of corner 3 is 1 minus their sum
};
static_assert(sizeof(TissueVertex) == 40);

/// A corner of a piece that is not a vertex of the mesh: a point of a triangle.
struct TissueCut {
  std::array<std::uint32_t, 3> vertex;  // the corners of the triangle
  std::uint32_t reserved = 0;
  std::array<double, 2> weight;  // of corners 1 and 2; that of corner 0 is 1 minus their sum
};
static_assert(sizeof(TissueCut) == 32);

/// The centre of a leaf: it lies at `depth` from a point of a triangle, in a direction that turns like a normal vector
/// of `tetrahedron`. A leaf therefore keeps its distance from the surface where the inside is compressed.
struct LeafAnchor {
  std::array<std::uint32_t, 3> vertex;  // the corners of the triangle
  std::array<float, 2> weight;          // of the point: of corners 1 and 2
  std::uint32_t tetrahedron;
  std::array<float, 3> direction;  // its dot products with the edges (b - a), (c - a), (d - a) of the tetrahedron at rest
  float depth;                     // [mm], >= 0
};
static_assert(sizeof(LeafAnchor) == 40);

/// The leaves of the tree in the order of levelSet() of its deepest level, and the pieces of the surface that each of
/// them contains.
struct TissueLeaves {
  std::vector<LeafAnchor> anchors;     // (leaves)
  std::vector<std::uint32_t> begin;    // (leaves + 1) index in `corners` of the first corner of a leaf's pieces
  std::vector<std::uint32_t> corners;  // i < number of vertices: vertex i; otherwise cut i - number of vertices
  std::vector<TissueCut> cuts;
};

/// A point of a triangle of the tetrahedra's outer surface.
struct PressPoint {
  std::array<std::uint32_t, 3> node;  // indices into TissueResponse::pressed, or kNone
  std::array<float, 3> weight;        // >= 0; they add up to 1

  /// The displacement of the point when the pressed nodes move by `nodes` (x, y, z of each).
  Eigen::Vector3d displacementIn(std::span<const float> nodes) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      if (node[k] == kNone) continue;
      const float* const u = nodes.data() + 3 * std::size_t{node[k]};
      sum += static_cast<double>(weight[k]) * Eigen::Vector3d(u[0], u[1], u[2]);
    }
    return sum;
  }
};
static_assert(sizeof(PressPoint) == 24);

/// Response of small deformations, for which displacements of the surface are linear in the forces on it. `matrix` is
/// the inverse of the stiffness matrix, condensed to the surface; it is symmetric and positive definite.
struct TissueResponse {
  std::vector<std::uint32_t> pressed;  // nodes of the tetrahedra's surface that can move; ascending
  std::vector<PressPoint> points;      // (vertices of the tree's skin, then its edges) the point that each moves with; that of a
                                       // vertex is also where a force on it acts
  std::vector<float> matrix;           // (pressed x 3 axes of the force) x (pressed x 3 axes of the displacement) [mm/N]

  bool empty() const { return pressed.empty(); }
  /// Displacements of the pressed nodes (x, y, z of each) under 1 N along an axis on pressed node `i`.
  std::span<const float> column(std::size_t i, std::size_t axis) const {
    return std::span(matrix).subspan((3 * i + axis) * 3 * pressed.size(), 3 * pressed.size());
  }
};

struct Tissue {
  TissueMaterial material;
  std::vector<std::array<double, 3>> nodes;              // at rest [mm]
  std::vector<std::array<std::uint32_t, 4>> tetrahedra;  // corners; (b - a) x (c - a) . (d - a) > 0
  std::vector<std::uint32_t> fixed;                      // nodes that do not move; ascending
  std::vector<TissueVertex> surface;                     // vertices of the mesh that the tree was built from, in its order
  TissueLeaves leaves;
  TissueResponse response;  // may be empty

  bool empty() const { return tetrahedra.empty(); }
  friend bool operator==(const Tissue&, const Tissue&);
};

/// Returns a sentence about the first value of `material` out of range, which gives the range and the usual mistake of
/// units, or "".
std::string findFault(const TissueMaterial& material);

/// Returns a sentence about the first broken rule, which names the element, or "" for sound tissue. Checks the
/// material, finite numbers, indices in range, `fixed` ascending, tetrahedra of positive volume, and the size of the
/// response. It cannot check that the pieces of the leaves make up the whole surface; the builder has to prove that.
/// Cost: O(size).
std::string findFault(const Tissue& tissue);

/// As above; also checks that the tissue has the leaves of `tree` and moves the vertices and edges of its skin.
std::string findFault(const Tissue& tissue, const SphereTree& tree);

/// The faces that belong to one tetrahedron only, counter-clockwise seen from outside, always in the same order.
std::vector<std::array<std::uint32_t, 3>> outerFaces(const Tissue& tissue);

/// Positions of the surface vertices when the nodes have moved by `displacements` (one for each node) [mm].
/// `positions`: one for each vertex. Cost: about 10 ns a vertex.
void moveSurface(const Tissue& tissue, std::span<const Eigen::Vector3d> displacements, std::span<Eigen::Vector3d> positions) noexcept;

/// The leaves when the nodes have moved by `displacements`, from the positions that moveSurface() computed. Together
/// they contain every point of the moved surface, whatever the displacements. `leaves`: one for each leaf. No
/// allocation. A leaf that holds no piece of the surface gets a radius of 1e-6 mm. If displacements are not finite, the
/// leaves are not finite either. Cost: about 10 ns a corner.
void moveLeaves(const Tissue& tissue, std::span<const Eigen::Vector3d> displacements, std::span<const Eigen::Vector3d> positions,
                std::span<Sphere> leaves) noexcept;

/// Returns `tree` with the leaves `leaves` (from moveLeaves()). Every inner node and every node of the search tree
/// encloses them. The skin is left out, because it is that of the shape at rest. The cover sphere of an inner node is
/// its bounding sphere, so that every level covers the moved surface. The tree is sound (findFault) if the leaves are
/// finite.
SphereTree movedTree(const SphereTree& tree, std::span<const Sphere> leaves);

}  // namespace spheretree
