// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/wall_shapes.h"

#include <algorithm>
#include <cmath>

#include "repair/fill_holes.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kStubTaper = 0.4;  // width of the end of a stub, as a share of its beginning: about that of a root's tip

Vector3d middleOf(const TriangleMesh& mesh, const std::vector<std::uint32_t>& loop) {
  Vector3d middle = Vector3d::Zero();
  for (const std::uint32_t v : loop) middle += mesh.positions[v] / static_cast<double>(loop.size());
  return middle;
}

/// Places of the inner end of a collar.
std::vector<Vector3d> innerRing(const TriangleMesh& mesh, const WallRim& rim, double depth, double edge, std::span<const Vector3d> normals,
                                const Vector3d& up) {
  const std::size_t n = rim.loop.size();
  std::vector<Vector3d> ring(n), move(n, -up);
  for (std::size_t i = 0; i < n; ++i) ring[i] = mesh.positions[rim.loop[i]];
  for (std::size_t i = 0; i < n; ++i)
    if (rim.loop[i] < normals.size()) move[i] = -normals[rim.loop[i]];
  const auto rounds = static_cast<std::size_t>(std::min(1000.0, std::pow(depth / edge, 2))) + 1;
  for (std::vector<Vector3d>* values : {&ring, &move})
    for (std::size_t round = 0; round < rounds; ++round) {
      const std::vector<Vector3d> before = *values;
      for (std::size_t i = 0; i < n; ++i)
        if (!rim.is_still[i]) (*values)[i] = (before[(i + n - 1) % n] + 2 * before[i] + before[(i + 1) % n]) / 4;
    }
  for (std::size_t i = 0; i < n; ++i)
    if (!rim.is_still[i]) ring[i] += depth * move[i].normalized();
  return ring;
}

}  // namespace

std::vector<Triangle> spanWall(TriangleMesh& mesh, const std::vector<std::uint32_t>& loop) {
  if (loop.size() < 3) return {};
  std::vector<Triangle> triangles = spanLoop(mesh, loop);
  if (triangles.empty()) {
    const auto hub = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.push_back(middleOf(mesh, loop));
    for (std::size_t i = 0; i < loop.size(); ++i) triangles.push_back({loop[i], loop[(i + 1) % loop.size()], hub});
  }
  return triangles;
}

Collar addCollar(TriangleMesh& mesh, const WallRim& rim, double depth, double edge, std::span<const Vector3d> normals, const Vector3d& up) {
  const std::vector<std::uint32_t>& loop = rim.loop;
  const std::vector<Vector3d> ring = innerRing(mesh, rim, depth, edge, normals, up);
  Collar out;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    out.inner.push_back(rim.is_still[i] ? loop[i] : static_cast<std::uint32_t>(mesh.positions.size()));
    if (!rim.is_still[i]) mesh.positions.push_back(ring[i]);
  }
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const std::size_t j = (i + 1) % loop.size();
    if (out.inner[j] != loop[j]) out.triangles.push_back({loop[i], loop[j], out.inner[j]});
    if (out.inner[i] != loop[i]) out.triangles.push_back({loop[i], out.inner[j], out.inner[i]});
  }
  return out;
}

std::vector<Triangle> addStub(TriangleMesh& mesh, const std::vector<std::uint32_t>& rim, double root, const Vector3d& up) {
  const Vector3d middle = middleOf(mesh, rim), end = middle - root * up;
  const auto first = static_cast<std::uint32_t>(mesh.positions.size()), n = static_cast<std::uint32_t>(rim.size());
  for (const std::uint32_t v : rim) {
    const Vector3d arm = mesh.positions[v] - middle;
    mesh.positions.push_back(end + kStubTaper * (arm - arm.dot(up) * up));
  }
  mesh.positions.push_back(end);
  std::vector<Triangle> triangles;
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t j = (i + 1) % n;
    triangles.push_back({rim[i], rim[j], first + j});
    triangles.push_back({rim[i], first + j, first + i});
    triangles.push_back({first + i, first + j, first + n});
  }
  return triangles;
}

}  // namespace spheretree::builder
