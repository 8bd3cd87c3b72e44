// SPDX-License-Identifier: GPL-3.0-or-later
#include "cut/layer_materials.h"

#include <algorithm>
#include <optional>

#include "geometry/distance_field.h"
#include "repair/subtract_solid.h"
#include "spheretree/core/rounding.h"

namespace spheretree::builder {

std::vector<LayerMaterial> layerMaterials(std::span<const TriangleMesh> layers, Progress& progress) {
  std::vector<LayerMaterial> out;
  for (std::size_t k = 0; k < layers.size(); ++k) {
    std::optional<Difference> left = Difference{layers[k]};
    const auto take = [&](const TriangleMesh& taken) {
      if (!left || left->mesh.triangles.empty() || taken.triangles.empty()) return;
      const double before = left->moved;
      left = subtractSolid(left->mesh, taken, progress);
      if (left) left->moved += before;
    };
    if (k > 0) {
      const std::optional<Difference> beyond = subtractSolid(layers[k], layers[0], progress);
      if (beyond) take(beyond->mesh);
      if (beyond && left)
        left->moved += beyond->moved;
      else
        left.reset();
    }
    for (std::size_t inner = k + 1; inner < layers.size(); ++inner) take(layers[inner]);
    LayerMaterial& material = out.emplace_back();
    material.mesh = left ? std::move(left->mesh) : layers[k];
    if (material.mesh.triangles.empty()) continue;
    const DistanceField field(material.mesh);
    const double moved = kRounding * field.diagonal() + (left ? left->moved : 0);
    const double error = 2 * moved * field.area();  // twice what is within `moved` of a flat surface
    material.volume = {left ? std::max(0.0, field.volume() - error) : 0, field.volume() + error};
  }
  return out;
}

}  // namespace spheretree::builder
