// SPDX-License-Identifier: GPL-3.0-or-later
// Reduces the triangles for the search, if the mesh is far finer than the spheres can follow. The statements about a
// tree are still proven against every triangle of the original mesh; docs/algorithms/mesh/simplify_mesh.md
//
// Half-edge collapses in the order of their quadric error, in rounds of collapses that do not touch each other. Paper:
// M. Garland, P. Heckbert. Surface simplification using quadric error metrics. SIGGRAPH 1997. OpenMesh's decimater is
// not used: it takes 40 s for a million triangles, these rounds take 3 s.
#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "geometry/distance_field.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// Reduces the triangles of a mesh step by step, so that several sizes of it cost little more than the smallest.
class MeshSimplifier {
 public:
  /// @throws std::invalid_argument for a mesh that is not manifold. `mesh` and `progress` have to outlive this object.
  MeshSimplifier(const TriangleMesh& mesh, Progress& progress);
  ~MeshSimplifier();

  /// Continues until about `triangles` triangles are left. There are more if every further collapse would turn over a
  /// triangle, make a sliver or change the topology. The vertices of the result are vertices of the mesh, in their
  /// order; parts are dropped. It is closed, oriented and manifold if the mesh is; it may intersect itself in walls
  /// thinner than its triangles.
  /// `max_error` [mm]: a collapse must not move a vertex to a place where the root mean square distance to its planes
  /// is larger; this, too, can end the reduction early.
  /// Deterministic for any number of threads. Cost: O(n log n), about 3 s of processor time for a million triangles.
  /// @throws Cancelled.
  TriangleMesh reduce(std::size_t triangles, double max_error = std::numeric_limits<double>::infinity());

  /// Continues with the collapses of these vertices of the last result, whatever they cost: what folds over itself
  /// there becomes flatter. Vertices stay that reduce() could not collapse either.
  TriangleMesh remove(std::span<const std::uint32_t> vertices);

  std::size_t triangles() const;  // that are left

  /// From now on, the vertices of results are those of another mesh, which must outlive this object: `vertex`
  /// (vertices) is their index there, and its lengths are `scale` times as large.
  void moveTo(const TriangleMesh& mesh, std::span<const std::uint32_t> vertex, double scale);

 private:
  class Collapses;
  TriangleMesh withVertices(std::vector<Triangle> triangles) const;
  const TriangleMesh* mesh_;
  std::unique_ptr<Collapses> collapses_;
};

/// One step of MeshSimplifier.
TriangleMesh simplifyMesh(const TriangleMesh& mesh, std::size_t triangles, Progress& progress,
                          double max_error = std::numeric_limits<double>::infinity());

/// Proven: no point of `mesh` is farther than this from the surface of `field` [mm]. The bound exceeds the largest
/// distance of a vertex by at most a quarter or 1e-6 of the diagonal, whichever is larger; if that would take more than
/// 1024 pieces for a triangle, it is larger, but still proven.
/// With `sufficient_bound`, the search ends as soon as a point with a larger distance is found, and the result is
/// infinite. It may then be as large as a quarter of `sufficient_bound`, or exceed the distance of some point by a
/// quarter. Deterministic for any number of threads. Cost: one distance query for each vertex, and a few pieces for
/// each triangle that bends over an edge of the other surface. @throws Cancelled.
double distanceBound(const TriangleMesh& mesh, const DistanceField& field, Progress& progress,
                     double sufficient_bound = std::numeric_limits<double>::infinity());

}  // namespace spheretree::builder
