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

#include "scene/tissue_model.h"
#include "spheretree/core/skin.h"

namespace spheretree::runtime {

/// A point of a triangle of the skin.
struct SkinPoint {
  std::uint32_t triangle = 0;
  std::array<double, 3> weight{};  // of the corners; >= 0, they add up to 1
};

struct SoftModel : TissueModel {
  /// A side of the skin or of a face, at rest: its length, and how it is bent, as the offset of its middle that follows
  /// from the angle between its end normals [mm].
  struct Side {
    float length = 0, bend = 0;
  };
  /// Of the skin: a vertex, or the middle of an edge. Everything that a step reads of it is together.
  struct Node {
    PressPoint point;                   // with which it moves
    SkinNode rest;                      // as in SkinNodes
    std::array<std::uint32_t, 3> fans;  // at each of its nodes; kNone if the node is held
    std::array<Side, 3> sides;          // of its face, from each of its nodes to the next
    Eigen::Vector3f normal{0, 0, 0};    // the mean normal of its fans; its own normal if nodes are held
  };
  struct alignas(64) Vertex : Node {
    float max_give = 0;  // largest displacement along a normal [mm]
  };
  struct alignas(64) Edge : Node {
    std::array<std::uint32_t, 2> end;  // vertices
    bool is_sharp;
    Side side;
    Eigen::Vector3f chord{0, 0, 0};  // at rest, from the first end to the second
    Eigen::Vector3f sag{0, 0, 0};    // at rest: from the middle of the points with which its ends move to that with which it moves
  };
  /// Faces around a node without a sharp edge between them; they share one normal there.
  struct Fan {
    std::uint32_t node;               // index of a pressed node
    std::uint32_t first, count;       // of its faces, in fan_sides
    Eigen::Vector3f normal{0, 0, 0};  // at rest
  };

  std::size_t node_count = 0;     // pressed nodes
  std::span<const float> matrix;  // (column: pressed node, axis of the force) x (pressed node, axis) [mm/N]

  std::vector<Vertex> vertices;
  std::vector<Edge> edges;
  std::vector<Eigen::Vector3f> node_places;         // (node of the tetrahedra's surface: the pressed ones, then the held ones) at rest
  std::vector<std::array<std::uint32_t, 3>> faces;  // triangles of the tetrahedra's surface, by indices into node_places
  std::vector<Fan> fans;
  std::vector<std::array<std::uint32_t, 2>> fan_sides;  // (face of a fan) the other two nodes of the face, counterclockwise

  const float* column(std::size_t i) const { return matrix.data() + i * 3 * node_count; }
};

/// `tree` and `tissue` must be sound and belong to each other, and the tree must have a skin.
std::shared_ptr<SoftModel> softModel(const SharedTree& tree, std::shared_ptr<const Tissue> tissue);

/// The normal of a fan with the surface's nodes at `places`; not of unit length.
Eigen::Vector3f normalOf(const SoftModel& model, const SoftModel::Fan& fan, std::span<const Eigen::Vector3f> places);

/// The offset of an edge's middle from its chord, relative to an edge with equal normals at both ends [mm].
float bendOf(const Eigen::Vector3f& chord, const Eigen::Vector3f& from_normal, const Eigen::Vector3f& to_normal);

}  // namespace spheretree::runtime
