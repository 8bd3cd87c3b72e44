// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/canonical_order.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numeric>
#include <tuple>
#include <utility>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr int kBits = 16;  // of each coordinate on the curve

// Interleaves the bits of three numbers, the highest bits first.
std::uint64_t interleaved(const std::array<std::uint32_t, 3>& cell) {
  std::uint64_t code = 0;
  for (int bit = kBits; bit-- > 0;)
    for (const std::uint32_t c : cell) code = code << 1 | (c >> bit & 1u);
  return code;
}

}  // namespace

std::uint64_t placeOnCurve(const Vector3d& p, const Eigen::AlignedBox3d& box) {
  const double side = box.isEmpty() ? 0 : box.sizes().maxCoeff();
  std::array<std::uint32_t, 3> cell{};
  for (int k = 0; k < 3 && side > 0; ++k) {
    const double share = std::clamp((p[k] - box.min()[k]) / side, 0.0, 1.0);
    cell[static_cast<std::size_t>(k)] = std::min(static_cast<std::uint32_t>(share * (1 << kBits)), (1u << kBits) - 1);
  }
  return interleaved(cell);
}

OrderedMesh inCanonicalOrder(const TriangleMesh& mesh) {
  OrderedMesh out;
  std::vector<std::uint32_t> by_place(mesh.positions.size()), place(mesh.positions.size());
  std::iota(by_place.begin(), by_place.end(), 0u);
  tbb::parallel_sort(by_place.begin(), by_place.end(), [&](std::uint32_t a, std::uint32_t b) {
    const Vector3d &p = mesh.positions[a], &q = mesh.positions[b];
    return std::tie(p.x(), p.y(), p.z(), a) < std::tie(q.x(), q.y(), q.z(), b);
  });
  Eigen::AlignedBox3d box;
  out.mesh.positions.reserve(by_place.size());
  for (std::uint32_t i = 0; i < by_place.size(); ++i) {
    place[by_place[i]] = i;
    out.mesh.positions.push_back(mesh.positions[by_place[i]]);
    box.extend(out.mesh.positions.back());
  }

  struct Keyed {
    std::uint64_t code;
    Triangle vertices;
    std::uint32_t triangle;
  };
  std::vector<Keyed> keyed(mesh.triangles.size());
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, static_cast<std::uint32_t>(keyed.size())), [&](const auto& range) {
    for (std::uint32_t t = range.begin(); t < range.end(); ++t) {
      const auto& [a, b, c] = mesh.triangles[t];
      Triangle v{place[a], place[b], place[c]};
      std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
      const Vector3d middle = (out.mesh.positions[v[0]] + out.mesh.positions[v[1]] + out.mesh.positions[v[2]]) / 3;
      keyed[t] = {placeOnCurve(middle, box), v, t};
    }
  });
  tbb::parallel_sort(keyed.begin(), keyed.end(), [](const Keyed& a, const Keyed& b) {
    return std::tie(a.code, a.vertices, a.triangle) < std::tie(b.code, b.vertices, b.triangle);
  });
  out.mesh.triangles.reserve(keyed.size());
  out.triangle.reserve(keyed.size());
  for (const Keyed& k : keyed) {
    out.mesh.triangles.push_back(k.vertices);
    out.triangle.push_back(k.triangle);
  }
  out.vertex = std::move(by_place);
  return out;
}

}  // namespace spheretree::builder
