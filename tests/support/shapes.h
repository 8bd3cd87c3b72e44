// SPDX-License-Identifier: Apache-2.0
// Meshes with known answers: closed, oriented outward, manifold.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "spheretree/core/mesh_edit.h"

namespace spheretree::test {

/// Axis-aligned box of 12 triangles.
inline TriangleMesh boxMesh(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.positions.emplace_back(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z());
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

/// Distance to the surface of that box, negative inside.
inline double boxDistance(const Eigen::Vector3d& low, const Eigen::Vector3d& high, const Eigen::Vector3d& p) {
  const Eigen::Vector3d beyond = (low - p).cwiseMax(p - high);
  return beyond.maxCoeff() > 0 ? beyond.cwiseMax(0.0).norm() : beyond.maxCoeff();
}

/// Each triangle cut into four: the same surface.
inline TriangleMesh quartered(TriangleMesh mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middle;
  const auto middleOf = [&](std::uint32_t a, std::uint32_t b) {
    const auto [at, is_new] = middle.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.positions.size()));
    if (is_new) mesh.positions.push_back(0.5 * (mesh.positions[a] + mesh.positions[b]));
    return at->second;
  };
  std::vector<Triangle> finer;
  for (const auto& [a, b, c] : mesh.triangles) {
    const std::uint32_t ab = middleOf(a, b), bc = middleOf(b, c), ca = middleOf(c, a);
    finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
  }
  mesh.triangles.swap(finer);
  return mesh;
}

/// Octahedron whose triangles are quartered `rounds` times, corners pushed onto the sphere: 8 * 4^rounds triangles.
inline TriangleMesh sphereMesh(double radius, int rounds) {
  TriangleMesh mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0}) mesh.positions.push_back(sign * Eigen::Vector3d::Unit(axis));
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int round = 0; round < rounds; ++round) {
    mesh = quartered(std::move(mesh));
    for (Eigen::Vector3d& p : mesh.positions) p.normalize();
  }
  for (Eigen::Vector3d& p : mesh.positions) p *= radius;
  return mesh;
}

/// Torus about the z axis, `around` by `across` quads.
inline TriangleMesh torusMesh(double big_radius, double small_radius, std::uint32_t around, std::uint32_t across) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j < across; ++j) {
      const double u = 2 * std::numbers::pi * i / around, v = 2 * std::numbers::pi * j / across;
      const double r = big_radius + small_radius * std::cos(v);
      mesh.positions.emplace_back(r * std::cos(u), r * std::sin(u), small_radius * std::sin(v));
    }
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j < across; ++j) {
      const std::uint32_t next_i = (i + 1) % around, next_j = (j + 1) % across;
      const std::uint32_t a = i * across + j, b = next_i * across + j, c = next_i * across + next_j, d = i * across + next_j;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  return mesh;
}

using spheretree::joined;

}  // namespace spheretree::test
