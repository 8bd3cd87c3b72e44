// SPDX-License-Identifier: Apache-2.0
// Meshes whose vertices lie on smooth surfaces with creases, and points of the patches of a skin, for comparison with
// these surfaces.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "spheretree/core/skin.h"
#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::test {

inline constexpr double kDegree = std::numbers::pi / 180;  // [rad]

/// Cylinder about the z axis from z = 0 to `height`, `around` by `along` quads, with a flat cap at either end: a fan
/// around its middle.
inline TriangleMesh cylinderMesh(double radius, double height, std::uint32_t around, std::uint32_t along) {
  TriangleMesh mesh;
  for (std::uint32_t j = 0; j <= along; ++j)
    for (std::uint32_t i = 0; i < around; ++i) {
      const double angle = 2 * std::numbers::pi * i / around;
      mesh.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), height * j / along);
    }
  for (std::uint32_t j = 0; j < along; ++j)
    for (std::uint32_t i = 0; i < around; ++i) {
      const std::uint32_t next = (i + 1) % around, a = j * around + i, b = j * around + next;
      mesh.triangles.push_back({a, b, b + around});
      mesh.triangles.push_back({a, b + around, a + around});
    }
  const auto bottom = static_cast<std::uint32_t>(mesh.positions.size()), top = bottom + 1;
  mesh.positions.emplace_back(0, 0, 0);
  mesh.positions.emplace_back(0, 0, height);
  for (std::uint32_t i = 0; i < around; ++i) {
    const std::uint32_t next = (i + 1) % around;
    mesh.triangles.push_back({bottom, next, i});
    mesh.triangles.push_back({top, along * around + i, along * around + next});
  }
  return mesh;
}

/// A slab with fillets of `radius` between its top and two sides, `across` strips wide: 0 <= x <= width, and the
/// fillets beyond; 0 <= y <= length; from z = 0 up to `height`.
inline TriangleMesh filletedSlab(double width, double length, double height, double radius, std::uint32_t across) {
  std::vector<Eigen::Vector2d> outline{{-radius, 0}, {width + radius, 0}};  // x, z; counter-clockwise seen from -y
  for (std::uint32_t i = 0; i <= across; ++i) {
    const double angle = 0.5 * std::numbers::pi * i / across;
    outline.emplace_back(width + radius * std::cos(angle), height - radius + radius * std::sin(angle));
  }
  for (std::uint32_t i = 0; i <= across; ++i) {
    const double angle = 0.5 * std::numbers::pi * (1 + static_cast<double>(i) / across);
    outline.emplace_back(radius * std::cos(angle), height - radius + radius * std::sin(angle));
  }
  TriangleMesh mesh;
  const auto n = static_cast<std::uint32_t>(outline.size());
  for (const double y : {0.0, length})
    for (const Eigen::Vector2d& p : outline) mesh.positions.emplace_back(p.x(), y, p.y());
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t next = (i + 1) % n;
    mesh.triangles.push_back({i, next + n, next});
    mesh.triangles.push_back({i, i + n, next + n});
  }
  for (std::uint32_t i = 1; i + 1 < n; ++i) {
    mesh.triangles.push_back({0, i, i + 1});
    mesh.triangles.push_back({n, n + i + 1, n + i});
  }
  return mesh;
}

/// A torus about the z axis whose vertices lie on it at irregular places, with diagonals in either direction: each
/// vertex is up to 0.24 of a cell beside its place in torusMesh(), so that no triangle is turned over.
inline TriangleMesh irregularTorus(double big_radius, double small_radius, std::uint32_t around, std::uint32_t across, std::uint64_t seed) {
  TriangleMesh mesh = torusMesh(big_radius, small_radius, around, across);
  Random random(seed);
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j < across; ++j) {
      const double u = 2 * std::numbers::pi * (i + random.between(-0.24, 0.24)) / around;
      const double v = 2 * std::numbers::pi * (j + random.between(-0.24, 0.24)) / across;
      const double r = big_radius + small_radius * std::cos(v);
      mesh.positions[i * across + j] = {r * std::cos(u), r * std::sin(u), small_radius * std::sin(v)};
    }
  for (std::size_t cell = 0; cell < mesh.triangles.size(); cell += 2)
    if (random.unit() < 0.5) {
      const auto [a, b, c] = mesh.triangles[cell];
      const std::uint32_t d = mesh.triangles[cell + 1][2];
      mesh.triangles[cell] = {a, b, d}, mesh.triangles[cell + 1] = {b, c, d};
    }
  return mesh;
}

struct PatchPoint {
  Eigen::Vector3d position, normal, flat;  // on the patch, its unit normal, on the flat triangle
};

/// By the formula in skin.h, in double. `w`: barycentric coordinates.
inline PatchPoint pointOf(const SkinPatch& patch, const Eigen::Vector3d& w) {
  PatchPoint out{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto i = static_cast<Eigen::Index>(k), j = static_cast<Eigen::Index>((k + 1) % 3);
    const double corner = w[i] * (2 * w[i] - 1), side = 4 * w[i] * w[j];
    out.position += corner * patch.position[k].cast<double>() + side * patch.position[3 + k].cast<double>();
    out.normal += corner * patch.normal[k].cast<double>() + side * patch.normal[3 + k].cast<double>();
    out.flat += w[i] * patch.position[k].cast<double>();
  }
  out.normal.normalize();
  return out;
}

/// Barycentric coordinates, evenly spread over the triangle.
inline Eigen::Vector3d randomPlace(Random& random) {
  double u = random.unit(), v = random.unit();
  if (u + v > 1) u = 1 - u, v = 1 - v;
  return {1 - u - v, u, v};
}

/// The largest errors of points relative to a surface.
struct SkinErrors {
  double position = 0;  // [mm]
  double normal = 0;    // [rad]
  double flat = 0;      // of the points of the flat triangles [mm]
};

/// For `samples` points of each patch that satisfies `counts` (all if empty). `project` gives the nearest point of the
/// surface and its normal.
inline SkinErrors errorsAgainst(const Skin& skin, const std::function<std::array<Eigen::Vector3d, 2>(const Eigen::Vector3d&)>& project,
                                const std::function<bool(const PatchPoint&)>& counts = {}, int samples = 20) {
  Random random(1);
  SkinErrors worst;
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
    const SkinPatch patch = patchOf(skin, t);
    for (int i = 0; i < samples; ++i) {
      const PatchPoint p = pointOf(patch, randomPlace(random));
      if (counts && !counts(p)) continue;
      const auto [q, n] = project(p.position);
      worst.position = std::max(worst.position, (p.position - q).norm());
      worst.normal = std::max(worst.normal, std::atan2(p.normal.cross(n).norm(), p.normal.dot(n)));
      worst.flat = std::max(worst.flat, (p.flat - project(p.flat)[0]).norm());
    }
  }
  return worst;
}

}  // namespace spheretree::test
