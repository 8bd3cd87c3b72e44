// SPDX-License-Identifier: Apache-2.0
// Soft tissue with known answers, made without the builder: an octahedron whose middle is held.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>

#include "spheretree/core/tissue.h"
#include "spheretree/runtime/scene.h"
#include "support/random.h"
#include "support/sample_skins.h"
#include "support/shape_trees.h"

namespace spheretree::test {

struct OctahedronTissue {
  runtime::SharedTree tree;  // one ball, with a round skin from an octahedron that is divided twice
  std::shared_ptr<const Tissue> tissue;
};

/// Where the surface of the octahedron is met on the way from its middle to `p`: on axis k at node 2 k or 2 k + 1, the
/// one on the side of `p`.
inline PressPoint onOctahedron(const Eigen::Vector3f& p, std::uint32_t held) {
  PressPoint point;
  const float sum = p.cwiseAbs().sum();
  for (std::uint32_t k = 0; k < 3; ++k) {
    const float x = p[static_cast<Eigen::Index>(k)];
    point.node[k] = 2 * k + (x < 0 ? 1 : 0);
    if (point.node[k] >= held) point.node[k] = kNone;
    point.weight[k] = std::abs(x) / sum;
  }
  return point;
}

/// Nodes: `radius` mm from the origin along +x, -x, +y, -y, +z, -z, and the origin. The first `pressed` of them can
/// move; the others are fixed. The compliance is a random positive definite matrix of about 1 mm/N.
inline OctahedronTissue octahedronTissue(float crease_angle, std::uint32_t pressed = 6, double radius = 5) {
  Skin skin = roundSkin(2, radius);
  skin.crease_angle = crease_angle;
  Tissue tissue;
  tissue.material = {15, 0.45, 1040};
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {radius, -radius}) {
      std::array<double, 3> node{};
      node[static_cast<std::size_t>(axis)] = sign;
      tissue.nodes.push_back(node);
    }
  tissue.nodes.push_back({0, 0, 0});
  for (const auto& [a, b, c] : dividedOctahedron(0).triangles) tissue.tetrahedra.push_back({6, a, b, c});
  for (std::uint32_t i = pressed; i < 7; ++i) tissue.fixed.push_back(i);
  for (std::uint32_t i = 0; i < 6; ++i) {  // each vertex is a corner of a tetrahedron, which is a node of the surface
    const auto t = static_cast<std::uint32_t>(std::find_if(tissue.tetrahedra.begin(), tissue.tetrahedra.end(),
                                                           [&](const auto& c) { return std::find(c.begin(), c.end(), i) != c.end(); }) -
                                              tissue.tetrahedra.begin());
    std::array<float, 3> weight{};
    for (std::size_t k = 0; k < 3; ++k) weight[k] = tissue.tetrahedra[t][k] == i;
    tissue.surface.push_back({tissue.nodes[i], t, weight});
    tissue.leaves.corners.push_back(i);
  }
  tissue.leaves.begin = {0, 6};
  tissue.leaves.anchors.push_back({{0, 2, 4}, {0, 0}, 0, {0, 0, 0}, 0});
  for (std::uint32_t i = 0; i < pressed; ++i) tissue.response.pressed.push_back(i);
  std::vector<PressPoint>& points = tissue.response.points;
  const SkinNodes nodes(skin);
  for (const SkinNode& vertex : nodes.ofVertices()) points.push_back(onOctahedron(vertex.position, pressed));
  points.resize(skin.vertices.size() + skin.edges.size());
  for (const SkinTriangle& t : skin.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3f a = nodes.ofVertices()[t.vertex[k]].position, b = nodes.ofVertices()[t.vertex[(k + 1) % 3]].position;
      points[skin.vertices.size() + t.edge[k]] = onOctahedron(0.5f * (a + b), pressed);
    }
  Random random(9);
  const auto size = static_cast<Eigen::Index>(3 * pressed);
  Eigen::MatrixXf half(size, size);
  for (float& x : half.reshaped()) x = static_cast<float>(random.between(-0.3, 0.3));
  const Eigen::MatrixXf compliance = half * half.transpose() + 0.5f * Eigen::MatrixXf::Identity(size, size);
  tissue.response.matrix.assign(compliance.reshaped().begin(), compliance.reshaped().end());
  OctahedronTissue out;
  out.tree = withSkin(oneBallTree(radius + 0.5), skin);
  EXPECT_EQ(findFault(tissue, *out.tree), "");
  out.tissue = std::make_shared<const Tissue>(std::move(tissue));
  return out;
}

}  // namespace spheretree::test
