// SPDX-License-Identifier: GPL-3.0-or-later
#include "cut/layer_materials.h"

#include <algorithm>
#include <optional>

#include "geometry/distance_field.h"
#include "repair/subtract_solid.h"

namespace spheretree::builder {
namespace {

constexpr double kMoved = 2e-5;  // of the diagonal: more than a cut moves any vertex

}  // namespace

std::vector<LayerMaterial> layerMaterials(std::span<const TriangleMesh> layers, Progress& progress) {
  std::vector<LayerMaterial> out;
  for (std::size_t k = 0; k < layers.size(); ++k) {
    std::optional<TriangleMesh> left = layers[k];
    const auto take = [&](const TriangleMesh& taken) {
      if (left && !left->triangles.empty() && !taken.triangles.empty()) left = subtractSolid(*left, taken, progress);
    };
    if (k > 0) {
      const std::optional<TriangleMesh> beyond = subtractSolid(layers[k], layers[0], progress);
      if (beyond)
        take(*beyond);
      else
        left.reset();
    }
    for (std::size_t inner = k + 1; inner < layers.size(); ++inner) take(layers[inner]);
    LayerMaterial& material = out.emplace_back();
    material.mesh = left ? std::move(*left) : layers[k];
    if (material.mesh.triangles.empty()) continue;
    const DistanceField field(material.mesh);
    const double error = kMoved * field.diagonal() * field.area();
    material.volume = {left ? std::max(0.0, field.volume() - error) : 0, field.volume() + error};
  }
  return out;
}

}  // namespace spheretree::builder
