// SPDX-License-Identifier: GPL-3.0-or-later
// What the edges of a mesh are on the surface that the mesh stands for: part of a smooth surface, straight in a flat
// face, or sharp. docs/algorithms/skin/skin.md
//
// - *Sharp*: the normals of its two triangles differ by more than the crease angle, or there are not two triangles, or
//   these disagree about which side is outside.
// - *Flat face*: triangles in one plane that stay flat. A facet of a curved surface is also a group of triangles in one
//   plane, but its neighbours are as wide as itself; a flat face of a machined part is wider than the strips of the
//   round surfaces that it runs into. So a group is a flat face if each edge around it is sharp, or leads to a group
//   that is narrower by kFlatWidth.
// - *Straight*: edges of flat faces and of long thin triangles.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

inline constexpr std::uint32_t kNoIndex = 0xffffffffu;

enum class EdgeKind : std::uint8_t { Smooth, Straight, Sharp };

struct SurfaceEdges {
  std::vector<std::array<std::uint32_t, 3>> edge;      // (triangles) of the sides 01, 12, 20
  std::vector<EdgeKind> kind;                          // (edges)
  std::vector<std::array<std::uint32_t, 2>> triangle;  // (edges) of its first two sides; the second is kNoIndex at a border
  std::vector<std::uint32_t> flat_face;                // (triangles) kNoIndex: of none
  std::vector<Eigen::Vector3d> face_normal;            // (flat faces) unit length
  std::vector<Eigen::Vector3d> triangle_normal;        // (triangles) unit length; zero for a triangle without area
  std::vector<char> is_fixed;                          // (vertices) on a sharp edge, of a flat face or of a long thin triangle

  bool isSharp(std::uint32_t e) const { return kind[e] == EdgeKind::Sharp; }
};

/// `crease_angle` [rad]. Triangles must have three different vertices. Cost: O(n log n).
SurfaceEdges classifyEdges(const TriangleMesh& mesh, double crease_angle);

}  // namespace spheretree::builder
