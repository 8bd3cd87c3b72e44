// SPDX-License-Identifier: GPL-3.0-or-later
#include "model/surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace spheretree::view {
namespace {

using Eigen::Vector3d;

/// Faces around each vertex: those of vertex v are face[begin[v]] .. face[begin[v + 1] - 1].
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

/// Points of the unit ball and triangles between them: an icosahedron whose triangles are divided into four `rounds`
/// times.
struct UnitBall {
  std::vector<Vector3d> points;
  std::vector<Triangle> triangles;

  explicit UnitBall(int rounds) {
    const double t = (1 + std::sqrt(5.0)) / 2;
    for (const double a : {-1.0, 1.0})
      for (const double b : {-t, t})
        for (const Vector3d& p : {Vector3d(a, b, 0), Vector3d(0, a, b), Vector3d(b, 0, a)}) points.push_back(p.normalized());
    // Three corners form a face if their distances are the edge length.
    const double edge = 2 / std::sqrt(1 + t * t) + 1e-9;
    for (std::uint32_t i = 0; i < 12; ++i)
      for (std::uint32_t j = i + 1; j < 12; ++j)
        for (std::uint32_t k = j + 1; k < 12; ++k) {
          const Vector3d &a = points[i], &b = points[j], &c = points[k];
          if ((a - b).norm() > edge || (b - c).norm() > edge || (c - a).norm() > edge) continue;
          triangles.push_back((b - a).cross(c - a).dot(a) > 0 ? Triangle{i, j, k} : Triangle{i, k, j});
        }
    for (int round = 0; round < rounds; ++round) cutInFour();
  }
  void cutInFour() {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [found, is_new] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(points.size()));
      if (is_new) points.push_back((points[a] + points[b]).normalized());
      return found->second;
    };
    std::vector<Triangle> finer;
    for (const auto& [a, b, c] : triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      for (const Triangle& part : {Triangle{a, ab, ca}, Triangle{ab, b, bc}, Triangle{ca, bc, c}, Triangle{ab, bc, ca}})
        finer.push_back(part);
    }
    triangles = std::move(finer);
  }
};

}  // namespace

void addBall(Surface& surface, const Vector3d& centre, double radius, int rounds) {
  const UnitBall unit(rounds);
  const auto first = static_cast<std::uint32_t>(surface.corners.size());
  for (const Vector3d& p : unit.points) surface.corners.push_back({(centre + radius * p).cast<float>(), p.cast<float>()});
  for (const Triangle& t : unit.triangles)
    for (const std::uint32_t corner : t) surface.indices.push_back(first + corner);
}

Surface surfaceOf(const TriangleMesh& mesh, double crease) {
  const FacesAround around(mesh);
  std::vector<Vector3d> area(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    area[t] = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
  const double smallest = std::cos(crease);
  Surface out;
  out.corners.reserve(mesh.positions.size() + mesh.positions.size() / 4);
  out.indices.reserve(3 * mesh.triangles.size());
  std::vector<std::vector<std::uint32_t>> corners_of(mesh.positions.size());  // corners made so far at a vertex
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t v : mesh.triangles[t]) {
      Vector3d sum = Vector3d::Zero();
      for (std::uint32_t k = around.begin[v]; k < around.begin[v + 1]; ++k) {
        const Vector3d& other = area[around.face[k]];
        if (other.dot(area[t]) >= smallest * other.norm() * area[t].norm()) sum += other;
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
