// SPDX-License-Identifier: GPL-3.0-or-later
#include "model/surface.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>

namespace spheretree::view {
namespace {

using Eigen::Vector3d;

/// Faces round each vertex: those of vertex v are face[begin[v]] .. face[begin[v + 1]].
struct FacesAround {
  std::vector<std::uint32_t> begin, face;

  explicit FacesAround(const TriangleMesh& mesh) : begin(mesh.positions.size() + 1), face(3 * mesh.triangles.size()) {
    for (const Triangle& t : mesh.triangles)
      for (const std::uint32_t v : t) ++begin[v + 1];
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) begin[v + 1] += begin[v];
    std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (const std::uint32_t v : mesh.triangles[t]) face[next[v]++] = static_cast<std::uint32_t>(t);
  }
};

}  // namespace

Surface surfaceOf(const TriangleMesh& mesh, double crease) {
  const FacesAround around(mesh);
  std::vector<Vector3d> area(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    area[t] = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
  const double least = std::cos(crease);
  Surface out;
  out.corners.reserve(mesh.positions.size() + mesh.positions.size() / 4);
  out.indices.reserve(3 * mesh.triangles.size());
  std::vector<std::vector<std::uint32_t>> corners_of(mesh.positions.size());  // corners made so far at a vertex
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t v : mesh.triangles[t]) {
      Vector3d sum = Vector3d::Zero();
      for (std::uint32_t k = around.begin[v]; k < around.begin[v + 1]; ++k) {
        const Vector3d& other = area[around.face[k]];
        if (other.dot(area[t]) >= least * other.norm() * area[t].norm()) sum += other;
      }
      const double length = sum.norm();
      const Eigen::Vector3f normal = (length > 0 ? Vector3d(sum / length) : Vector3d::UnitZ()).cast<float>();
      std::uint32_t corner = ~0u;
      for (const std::uint32_t made : corners_of[v])
        if (out.corners[made].normal == normal) corner = made;
      if (corner == ~0u) {
        corner = static_cast<std::uint32_t>(out.corners.size());
        out.corners.push_back({mesh.positions[v].cast<float>(), normal});
        corners_of[v].push_back(corner);
      }
      out.indices.push_back(corner);
    }
  }
  return out;
}

Surface surfaceOf(const Skin& skin) {
  constexpr std::array<std::uint32_t, 12> kFour{0, 3, 5, 3, 1, 4, 5, 4, 2, 3, 4, 5};
  Surface out;
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
    const SkinPatch patch = patchOf(skin, t);
    const auto first = static_cast<std::uint32_t>(out.corners.size());
    for (std::size_t k = 0; k < 6; ++k) out.corners.push_back({patch.position[k], patch.normal[k].normalized()});
    for (const std::uint32_t k : kFour) out.indices.push_back(first + k);
  }
  return out;
}

}  // namespace spheretree::view
