// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/soften_tree.h"

#include <stdexcept>
#include <string>

#include "spheretree/builder/build_settings.h"
#include "tissue/anchor_leaves.h"
#include "tissue/bind_surface.h"
#include "tissue/cut_pieces.h"
#include "tissue/elasticity.h"
#include "tissue/surface_response.h"
#include "tissue/tetrahedra.h"

namespace spheretree::builder {

using Eigen::Vector3d;

Tissue softenTree(const TriangleMesh& surface, const SphereTree& tree, const TriangleMesh& boundary, const TetrahedronList& tetrahedra,
                  const TissueMaterial& material, const std::function<bool(const Vector3d&)>& is_fixed, Progress& progress) {
  if (const std::string fault = findFault(material); !fault.empty()) throw std::invalid_argument(fault);
  const Tetrahedra solid = solidOf(tetrahedra, boundary);
  const Vector3d origin(tree.origin_mm[0], tree.origin_mm[1], tree.origin_mm[2]);
  Tissue tissue;
  tissue.material = material;
  std::vector<char> fixed;
  for (const Vector3d& p : solid.nodes) {
    const Vector3d at = p - origin;
    tissue.nodes.push_back({at.x(), at.y(), at.z()});
    fixed.push_back(is_fixed(p));
    if (fixed.back()) tissue.fixed.push_back(static_cast<std::uint32_t>(tissue.nodes.size() - 1));
  }
  tissue.tetrahedra = solid.corners;
  progress.stage("stiffness");
  const TriangleMesh outside = boundaryOf(solid);
  tissue.response = surfaceResponse(Elasticity(solid, material, fixed, progress), outside, progress);  // throws if a part is not held
  progress.stage("bind the surface");
  tissue.surface = bindSurface(surface, solid, origin, progress);
  progress.stage("cut the surface");
  std::vector<Sphere> leaves;
  for (const std::uint32_t leaf : levelSet(tree, tree.levelCount() - 1)) leaves.push_back(tree.cover[leaf]);
  tissue.leaves = cutPieces(surface, leaves, origin, progress);
  tissue.leaves.anchors = anchorLeaves(surface, DistanceField(surface), tissue.surface, solid, leaves, origin);
  if (!tissue.response.empty()) tissue.response.points = pressPoints(outside, tree.skin, origin, tissue.response.pressed);
  if (const std::string fault = findFault(tissue, tree); !fault.empty()) throw BuildError("tissue: " + fault);
  return tissue;
}

}  // namespace spheretree::builder
