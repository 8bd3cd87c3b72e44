// SPDX-License-Identifier: Apache-2.0
// The data that all objects of one soft tissue share: its skin at rest, the nodes that each vertex moves with, and the
// compliance. Computed once, when the tissue is loaded.
// Units: mm, N; frame of the file's spheres.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "soft_tissue.h"
#include "spheretree/core/skin.h"

namespace spheretree::runtime {

struct SoftModel : TissueModel {
  /// A smooth edge: the vertices at its ends, and the bend of the edge at rest, as the offset of its middle that
  /// follows from the angle between its end normals [mm].
  struct Edge {
    std::array<std::uint32_t, 2> end;
    float bend;
  };
  /// Faces around a node without a sharp edge between them; they share one normal there.
  struct Fan {
    std::uint32_t node;  // index of a pressed node
    std::vector<std::uint32_t> faces;
    Eigen::Vector3f normal;  // at rest
  };
  /// A triangle of the tetrahedra's surface.
  struct Face {
    std::array<std::uint32_t, 3> node;  // pressed nodes, or kHeldNode
    std::array<Eigen::Vector3f, 3> rest;
  };

  std::size_t node_count = 0;          // pressed nodes
  std::span<const PressPoint> points;  // (vertex of the skin) the point with which it moves
  std::vector<float> max_give;         // (vertex) largest displacement along a normal [mm]
  std::span<const float> matrix;       // (column: pressed node, axis of the force) x (pressed node, axis) [mm/N]

  std::vector<SkinNode> vertices, edge_middles;  // of the skin at rest
  std::vector<Edge> edges;                       // (edge)
  std::vector<Face> faces;
  std::vector<Fan> fans;
  std::vector<Eigen::Vector3f> node_places;               // (pressed node) at rest
  std::vector<std::array<std::uint32_t, 3>> vertex_fans;  // (vertex) its fan at each of its nodes; kHeldNode if the node is held
  std::vector<Eigen::Vector3f> vertex_normals;            // (vertex) the mean normal of these fans; its own normal if nodes are held

  const float* column(std::size_t i) const { return matrix.data() + i * 3 * node_count; }
};

/// `tree` and `tissue` must be sound and belong to each other, and the tree must have a skin.
std::shared_ptr<SoftModel> softModel(const SharedTree& tree, std::shared_ptr<const Tissue> tissue);

/// The normal of a fan with the pressed nodes displaced by `shift`; not of unit length.
Eigen::Vector3f normalOf(const SoftModel& model, const SoftModel::Fan& fan, std::span<const float> shift);

/// The offset of an edge's middle from its chord, relative to an edge with equal normals at both ends [mm].
float bendOf(const Eigen::Vector3f& chord, const Eigen::Vector3f& from_normal, const Eigen::Vector3f& to_normal);

}  // namespace spheretree::runtime
