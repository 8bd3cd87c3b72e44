// SPDX-License-Identifier: Apache-2.0
#include "scene/cut_model.h"

#include "cut/cutter.h"
#include "spheretree/core/search_tree.h"

namespace spheretree::runtime {
namespace {

constexpr double kFarthest = 1e6;                        // of a layer [mm]
constexpr double kLeastRate = 1e-3, kLargestRate = 1e3;  // [mm/(N s)]; enamel has about 1, soft caries 10

std::unique_ptr<Cutting> makeCutter(StepMemory& memory) { return std::make_unique<Cutter>(memory); }

std::string faultIn(const TriangleMesh* surface) {
  if (!surface || surface->triangles.empty()) return "its surface has no triangle";
  if (surface->triangles.size() > kMaxSearchItems)
    return "its surface has " + std::to_string(surface->triangles.size()) + " triangles; at most " + std::to_string(kMaxSearchItems) +
           ": simplify it";
  for (const Eigen::Vector3d& p : surface->positions)
    if (!(p.cwiseAbs().maxCoeff() <= kFarthest)) return "a vertex of its surface is not within 1e6 mm";
  for (const Triangle& triangle : surface->triangles)
    for (const std::uint32_t v : triangle)
      if (v >= surface->positions.size()) return "a triangle of its surface has a vertex that does not exist";
  return {};
}

std::string faultIn(const SharedTree& tree, const CutMaterial& material) {
  if (tree->skin.empty()) return "the tree has no skin; build it anew from its mesh";
  if (material.inner.size() + 1 > kMaxCutLayers) return "at most " + std::to_string(kMaxCutLayers) + " layers";
  if (!(material.tangential >= 0 && material.tangential <= 2)) return "the tangential force is not within 0 .. 2 of the normal force";
  const auto isRate = [](double rate) { return rate >= kLeastRate && rate <= kLargestRate; };
  if (!isRate(material.removal)) return "the removal rate of the object is not within 0.001 .. 1000 mm/(N s)";
  for (std::size_t i = 0; i < material.inner.size(); ++i) {
    const CutLayer& layer = material.inner[i];
    const std::string name = "layer " + std::to_string(i + 1);
    if (std::string why = faultIn(layer.surface.get()); !why.empty()) return name + ": " + why;
    if (!isRate(layer.removal)) return name + ": its removal rate is not within 0.001 .. 1000 mm/(N s)";
  }
  return {};
}

}  // namespace

std::shared_ptr<const CutModel> cutModel(const SharedTree& tree, CutMaterial material, std::string& fault) {
  fault = faultIn(tree, material);
  if (!fault.empty()) return nullptr;
  return std::make_shared<const CutModel>(CutModel{tree, std::move(material), makeCutter});
}

}  // namespace spheretree::runtime
