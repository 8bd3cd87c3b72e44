// SPDX-License-Identifier: Apache-2.0
// What all surfaces of one piece of soft tissue share: its skin at rest, what its vertices go with, and how forces move
// that. Made once, when the tissue is loaded.
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
  /// Of a smooth edge: the vertices at its ends, and how much their normals lean apart at rest, as an offset of the
  /// middle [mm].
  struct Edge {
    std::array<std::uint32_t, 2> end;
    float bend;
  };
  /// Faces round a node with no sharp edge between them, which have one normal there.
  struct Fan {
    std::uint32_t node;  // pressed
    std::vector<std::uint32_t> faces;
    Eigen::Vector3f normal;  // at rest
  };
  /// A triangle of the tetrahedra's surface.
  struct Face {
    std::array<std::uint32_t, 3> node;  // pressed nodes, or kHeldNode
    std::array<Eigen::Vector3f, 3> rest;
  };

  std::size_t node_count = 0;          // pressed nodes
  std::span<const PressPoint> points;  // (vertex of the skin) what it goes with
  std::vector<float> most_give;        // (vertex) it moves no farther along a normal [mm]
  std::span<const float> matrix;       // (column: pressed node, axis of the force) x (pressed node, axis) [mm/N]

  std::vector<SkinNode> vertices, edge_middles;  // of the skin at rest
  std::vector<Edge> edges;                       // (edge)
  std::vector<Face> faces;
  std::vector<Fan> fans;
  std::vector<Eigen::Vector3f> node_places;               // (pressed node) at rest
  std::vector<std::array<std::uint32_t, 3>> vertex_fans;  // (vertex) at each of its nodes the one that it is on; kHeldNode
  std::vector<Eigen::Vector3f> vertex_normals;            // (vertex) the mean of theirs; where nodes are held, its own

  const float* column(std::size_t i) const { return matrix.data() + i * 3 * node_count; }
};

/// `tree` and `tissue` are sound, belong to each other, and the tree has a skin.
std::shared_ptr<SoftModel> softModel(const SharedTree& tree, std::shared_ptr<const Tissue> tissue);

/// With the pressed nodes displaced by `shift`; not of unit length.
Eigen::Vector3f normalOf(const SoftModel& model, const SoftModel::Fan& fan, std::span<const float> shift);

/// How far the middle of an edge lies off its chord, beyond what it does where both normals are the same [mm].
float bendOf(const Eigen::Vector3f& chord, const Eigen::Vector3f& from_normal, const Eigen::Vector3f& to_normal);

}  // namespace spheretree::runtime
