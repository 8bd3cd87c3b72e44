// SPDX-License-Identifier: Apache-2.0
#include "compiled_skin.h"

#include <algorithm>

namespace spheretree::runtime {
namespace {

std::uint16_t packed(float component) {
  const float scaled = component * kNormalScale;
  return static_cast<std::uint16_t>(static_cast<std::int16_t>(scaled + (scaled < 0 ? -0.5f : 0.5f)));
}

CompiledPatch compilePatch(const SkinPatch& patch, const Eigen::Vector3f& origin) {
  CompiledPatch out{};
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<Eigen::Index>(axis);
      out.position[i][axis] = patch.position[i][a] + origin[a];
      out.normal[i][axis] = packed(patch.normal[i][a]);
    }
  out.flags = allowanceOf(patch, 1) > 0 ? kCurved : 0;
  for (std::size_t k = 0; k < 3; ++k) out.flags |= static_cast<std::uint32_t>(patch.is_sharp[k]) << k;
  return out;
}

}  // namespace

CompiledSkin compileSkin(const Skin& skin, const Eigen::Vector3d& origin) {
  CompiledSkin out;
  if (skin.empty()) return out;
  out.tolerance = skin.tolerance;
  std::vector<Sphere> spheres;
  spheres.reserve(skin.triangles.size());
  out.patch.reserve(skin.triangles.size());
  const Eigen::Vector3f shift = origin.cast<float>();
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
    const SkinPatch patch = patchOf(skin, t);
    spheres.push_back(enclose(patch));
    out.patch.push_back(compilePatch(patch, shift));
  }
  out.tree = compileTree(skin.search, spheres, origin);
  out.tree.exact = {};    // only the published algorithm asks for exact pairs, and it meets leaves
  out.tree.spheres = {};  // rows are of triangles, unless a list is full
  return out;
}

}  // namespace spheretree::runtime
