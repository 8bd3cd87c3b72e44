// SPDX-License-Identifier: Apache-2.0
#include "probe.h"

#include <array>
#include <cmath>
#include <vector>

namespace spheretree::samples {
namespace {

using Eigen::Vector3d;
constexpr std::uint32_t kCorners = 16;

struct Ring {
  Vector3d centre, side;  // [mm]; unit, in the plane of the hook
  double radius;          // [mm]
};

struct Bezier {
  std::array<Vector3d, 4> control;
  Vector3d at(double t) const {
    const double s = 1 - t;
    return s * s * s * control[0] + 3 * s * s * t * control[1] + 3 * s * t * t * control[2] + t * t * t * control[3];
  }
  Vector3d tangent(double t) const {
    const double s = 1 - t;
    return (s * s * (control[1] - control[0]) + 2 * s * t * (control[2] - control[1]) + t * t * (control[3] - control[2])).normalized();
  }
};

// Only square roots: the sine of a maths library may differ in its last bit from machine to machine.
std::array<Vector3d, kCorners> unitCircle() {
  const double half = std::sqrt(0.5), wide = std::sqrt((1 + half) / 2), narrow = std::sqrt((1 - half) / 2);
  const std::array<double, 5> cosine{1, wide, half, narrow, 0};
  std::array<Vector3d, kCorners> circle;
  for (std::uint32_t k = 0; k < kCorners; ++k) {
    const std::uint32_t in_quarter = k % 4;
    const double c = cosine[in_quarter], s = cosine[4 - in_quarter];
    constexpr std::array<std::array<int, 4>, 4> kTurn{{{1, 0, 0, 1}, {0, -1, 1, 0}, {-1, 0, 0, -1}, {0, 1, -1, 0}}};
    const auto& turn = kTurn[k / 4];
    circle[k] = Vector3d(turn[0] * c + turn[1] * s, turn[2] * c + turn[3] * s, 0);
  }
  return circle;
}

std::vector<Ring> rings() {
  const Vector3d side(1, 0, 0);  // right of the shaft, as it comes down
  std::vector<Ring> rings;
  // The rounded end of the shaft, and the shaft down to the bend.
  constexpr std::array<std::array<double, 2>, 11> kShaft{{{33.95, 0.65},
                                                          {33.7, 1.0},
                                                          {33.2, 1.2},
                                                          {31, 1.2},
                                                          {28.5, 1.2},
                                                          {27.7, 1.1},
                                                          {26.9, 0.98},
                                                          {23.5, 0.87},
                                                          {20, 0.76},
                                                          {16.5, 0.65},
                                                          {13, 0.55}}};
  for (const auto& [z, radius] : kShaft) rings.push_back({{3.5, 0, z}, side, radius});
  const Bezier bend{{Vector3d(3.5, 0, 13), Vector3d(3.5, 0, 9.5), Vector3d(6.6, 0, 9.2), Vector3d(6.6, 0, 5.6)}};
  const Bezier hook{{Vector3d(6.6, 0, 5.6), Vector3d(6.6, 0, 2.0), Vector3d(3.9, 0, 0.75), Vector3d(0, 0, 0)}};
  const auto sweep = [&rings](const Bezier& curve, double t, double radius) {
    const Vector3d along = curve.tangent(t);
    rings.push_back({curve.at(t), Vector3d(-along.z(), 0, along.x()), radius});
  };
  constexpr int kBend = 8, kHook = 12;
  for (int i = 1; i <= kBend; ++i) sweep(bend, static_cast<double>(i) / kBend, 0.55 - 0.17 * i / kBend);
  for (int i = 1; i <= kHook; ++i) sweep(hook, 0.965 * i / kHook, 0.38 - 0.28 * i / kHook);
  // The tip, closed as a rounded point: three rings and the origin.
  sweep(hook, 0.98, 0.08);
  sweep(hook, 0.99, 0.06);
  sweep(hook, 0.997, 0.033);
  return rings;
}

}  // namespace

TriangleMesh makeProbe() {
  TriangleMesh mesh;
  const std::array<Vector3d, kCorners> circle = unitCircle();
  const std::vector<Ring> all = rings();
  for (const Ring& ring : all) {
    for (const Vector3d& c : circle) mesh.positions.push_back(ring.centre + ring.radius * (c.x() * ring.side + c.y() * Vector3d(0, 1, 0)));
  }
  const auto top = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.push_back({3.5, 0, 34});
  mesh.positions.push_back(Vector3d::Zero());
  const auto ring_count = static_cast<std::uint32_t>(all.size());
  for (std::uint32_t k = 0; k < kCorners; ++k) {
    const std::uint32_t next = (k + 1) % kCorners;
    mesh.triangles.push_back({top, k, next});
    for (std::uint32_t ring = 0; ring + 1 < ring_count; ++ring) {
      const std::uint32_t upper = ring * kCorners, lower = upper + kCorners;
      mesh.triangles.push_back({upper + k, lower + k, lower + next});
      mesh.triangles.push_back({upper + k, lower + next, upper + next});
    }
    const std::uint32_t last = (ring_count - 1) * kCorners;
    mesh.triangles.push_back({last + k, top + 1, last + next});
  }
  return mesh;
}

}  // namespace spheretree::samples
