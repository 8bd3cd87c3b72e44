// SPDX-License-Identifier: GPL-3.0-or-later
// Classifies the edges of a mesh by what they are on the smooth surface: smooth, straight within a flat face, or sharp.
// docs/algorithms/skin/skin.md
//
// - *Sharp*: the normals of its two triangles differ by more than the crease angle, or it does not have two triangles,
//   or these disagree about which side is outside.
// - *Flat face*: coplanar triangles that stay flat. A facet of a curved surface is also a group of coplanar triangles,
//   but its neighbours are as wide as itself; a flat face of a machined part is wider than the strips of the round
//   surfaces next to it. Therefore a group is a flat face if each edge around it is sharp, or leads to a group that is
//   narrower by kFlatWidth.
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
  std::vector<std::array<std::uint32_t, 3>> edge;      // (triangles) edge of the sides 01, 12, 20
  std::vector<EdgeKind> kind;                          // (edges)
  std::vector<std::array<std::uint32_t, 2>> triangle;  // (edges) triangles of its first two sides; the second is kNoIndex at a border
  std::vector<std::uint32_t> flat_face;                // (triangles) kNoIndex: not in a flat face
  std::vector<Eigen::Vector3d> face_normal;            // (flat faces) unit length
  std::vector<Eigen::Vector3d> triangle_normal;        // (triangles) unit length; zero for a triangle without area
  std::vector<char> is_fixed;                          // (vertices) on a sharp edge, or part of a flat face or of a long thin triangle

  bool isSharp(std::uint32_t e) const { return kind[e] == EdgeKind::Sharp; }
};

/// `crease_angle` [rad]. Triangles must have three different vertices. Cost: O(n log n).
SurfaceEdges classifyEdges(const TriangleMesh& mesh, double crease_angle);

}  // namespace spheretree::builder
