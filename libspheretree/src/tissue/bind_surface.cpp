// SPDX-License-Identifier: GPL-3.0-or-later
#include "tissue/bind_surface.h"

#include <tbb/parallel_for.h>

#include <Eigen/LU>
#include <algorithm>
#include <limits>

#include "geometry/box_tree.h"
#include "geometry/distance_field.h"
#include "spheretree/core/rounding.h"

namespace spheretree::builder {

using Eigen::Vector3d;

std::vector<TissueVertex> bindSurface(const TriangleMesh& mesh, const Tetrahedra& solid, const Vector3d& origin, Progress& progress) {
  const DistanceField boundary(boundaryOf(solid));
  std::vector<Eigen::AlignedBox3d> boxes(solid.corners.size());
  std::vector<Eigen::Matrix3d> inverse(solid.corners.size());
  for (std::size_t t = 0; t < boxes.size(); ++t) {
    const auto& c = solid.corners[t];
    for (const std::uint32_t node : c) boxes[t].extend(solid.nodes[node]);
    Eigen::Matrix3d edges;
    for (int k = 0; k < 3; ++k) edges.col(k) = solid.nodes[c[static_cast<std::size_t>(k)]] - solid.nodes[c[3]];
    inverse[t] = edges.inverse();
  }
  const BoxTree tree(boxes, 4);
  std::vector<TissueVertex> bound(mesh.positions.size());
  tbb::parallel_for(std::size_t{0}, bound.size(), [&](std::size_t v) {
    progress.check();
    const Vector3d& p = mesh.positions[v];
    // Padded, so that a vertex on a face is in range of both tetrahedra.
    const double reach = std::max(0.0, boundary.signedDistance(p)) + kRounding * boundary.diagonal();
    double best = -std::numeric_limits<double>::infinity();
    std::uint32_t best_tetrahedron = 0;
    Vector3d best_weight = Vector3d::Zero();
    tree.searchWithin(p, reach * reach, [&](std::size_t first, std::size_t count) {
      for (std::size_t slot = first; slot < first + count; ++slot) {
        const std::uint32_t t = tree.order()[slot];
        const Vector3d w = inverse[t] * (p - solid.nodes[solid.corners[t][3]]);
        const double smallest = std::min(w.minCoeff(), 1 - w.sum());
        if (smallest > best || (smallest == best && t < best_tetrahedron)) best = smallest, best_tetrahedron = t, best_weight = w;
      }
    });
    const Vector3d rest = p - origin;
    bound[v] = {{rest.x(), rest.y(), rest.z()},
                best_tetrahedron,
                {roundToFloat(best_weight.x()), roundToFloat(best_weight.y()), roundToFloat(best_weight.z())}};
  });
  return bound;
}

}  // namespace spheretree::builder
