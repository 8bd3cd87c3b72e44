// SPDX-License-Identifier: Apache-2.0
#include "scene/winding_number.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>

namespace spheretree::runtime {
namespace {

constexpr double kFar = 2;                  // triangles below a node are seen as one face from this many radii
constexpr std::uint32_t kTriangleWork = 5;  // cost of a solid angle, in 8-lane tests

Eigen::Vector3d vectorOf(const float (&p)[3]) { return {p[0], p[1], p[2]}; }

double halfSolidAngle(const CompiledPatch& patch, const Eigen::Vector3d& point) {
  Eigen::Vector3d v[3];
  for (int k = 0; k < 3; ++k) v[k] = vectorOf(patch.position[k]) - point;
  const double a = v[0].norm(), b = v[1].norm(), c = v[2].norm();
  return std::atan2(v[0].dot(v[1].cross(v[2])), a * b * c + v[0].dot(v[1]) * c + v[1].dot(v[2]) * a + v[2].dot(v[0]) * b);
}

}  // namespace

double windingNumber(const CompiledSkin& skin, const Eigen::Vector3d& point, std::uint32_t& work) {
  std::array<std::uint32_t, 128> open{};  // blocks
  std::size_t count = 1;
  double half_angles = 0;
  while (count > 0) {
    const std::uint32_t block = open[--count];
    for (std::uint32_t lane = 0; lane < 8; ++lane) {
      if (const std::uint32_t item = skin.tree.item[8 * block + lane]; item != kNoItem) {
        half_angles += halfSolidAngle(skin.patch[item], point);
        work += kTriangleWork;
      } else if (lane < skin.tree.links[block].inner) {
        const std::uint32_t child = skin.tree.links[block].first_child + lane;
        const FarFace& face = skin.far[child];
        const Eigen::Vector3d way = vectorOf(face.centre) - point;
        const double distance = way.norm();
        ++work;
        if (distance > kFar * static_cast<double>(face.radius) || count == open.size())
          half_angles += 0.5 * vectorOf(face.area).dot(way) / (distance * distance * distance);
        else
          open[count++] = child;
      }
    }
  }
  return half_angles / (2 * M_PI);
}

}  // namespace spheretree::runtime
