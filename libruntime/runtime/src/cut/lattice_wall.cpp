// SPDX-License-Identifier: Apache-2.0
#include "cut/lattice_wall.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;

// All in spacings.
constexpr double kRimNear = 0.87;       // of a point of the rim from the nearest point of the lattice: half of a cell's diagonal
constexpr double kRimCell = 0.6;        // along each axis, of a ball from its point: half a cell, and a little that overlaps
constexpr double kRimBall = 0.1;        // radius that two balls of a point aim at, kRimApart from each other,
constexpr double kSecondBall = 0.5;     // and the third, which closes the gap to the balls of the wall
constexpr double kRimError = 1.0 / 64;  // of the interpolation beside a burr of 8 spacings
constexpr double kRimApart = 0.5;       // of the two balls of a point
constexpr double kRimAngle = 0.1;       // least square of the sine between both surfaces: below, there is no rim

}  // namespace

Sphere LatticeWall::ball(const CutBlock& block, std::size_t point) const {
  const Vector3d corner = lattice_.cornerOf(block.place);
  return {static_cast<float>(corner[0] + spacing_ * static_cast<double>(point & 7)),
          static_cast<float>(corner[1] + spacing_ * static_cast<double>(point >> 3 & 7)),
          static_cast<float>(corner[2] + spacing_ * static_cast<double>(point >> 6)),
          std::min(block.clearance[point], block.depth[point]) - static_cast<float>(kCutPlay)};
}

bool LatticeWall::gradientsAt(const CutBlock& block, std::size_t point, Vector3d& depth, Vector3d& clearance) const {
  for (int axis = 0; axis < 3; ++axis) {
    const int at = static_cast<int>(point >> 3 * axis & 7);
    depth[axis] = clearance[axis] = 0;
    for (const int sign : {-1, 1}) {
      const CutBlock* beside = &block;
      if (at + sign < 0 || at + sign > 7) {
        BlockPlace place = block.place;
        place[static_cast<std::size_t>(axis)] += sign;
        beside = lattice_.blockAt(place);
        if (!beside) return false;
      }
      const std::size_t other = (point & ~(std::size_t{7} << 3 * axis)) | static_cast<std::size_t>((at + sign) & 7) << 3 * axis;
      depth[axis] += sign * static_cast<double>(beside->depth[other]) / (2 * spacing_);
      clearance[axis] += sign * static_cast<double>(beside->clearance[other]) / (2 * spacing_);
    }
  }
  return true;
}

std::span<const Sphere> LatticeWall::rimOf(CutBlock& block) const {
  if (!block.knows_rim) findRim(block);
  return {block.rim, block.rim_count};
}

void LatticeWall::findRim(CutBlock& block) const {
  block.knows_rim = true;
  block.rim_count = 0;
  if (!block.meets_surface) return;
  const auto near = static_cast<float>(kRimNear * spacing_);
  const auto add = [&](const Vector3d& centre) {
    const Material material = lattice_.at(centre);
    const double radius = static_cast<double>(std::min(material.depth, material.clearance)) - kCutPlay - kRimError * spacing_;
    if (radius > 0 && block.rim_count < kMaxRimBalls)
      block.rim[block.rim_count++] = {static_cast<float>(centre.x()), static_cast<float>(centre.y()), static_cast<float>(centre.z()),
                                      static_cast<float>(radius)};
  };
  for (std::size_t point = 0; point < kBlockPoints; ++point) {
    if (!(std::abs(block.depth[point]) < near && std::abs(block.clearance[point]) < near)) continue;
    Vector3d of_depth, of_clearance;
    if (!gradientsAt(block, point, of_depth, of_clearance)) continue;
    const double a = of_depth.squaredNorm(), b = of_depth.dot(of_clearance), c = of_clearance.squaredNorm(), determinant = a * c - b * b;
    if (!(determinant > kRimAngle)) continue;
    // The shortest way to where both fields are `aim`.
    const auto wayTo = [&](double aim) {
      const double depth = aim - static_cast<double>(block.depth[point]), clearance = aim - static_cast<double>(block.clearance[point]);
      return Vector3d(((c * depth - b * clearance) * of_depth + (a * clearance - b * depth) * of_clearance) / determinant);
    };
    const Vector3d way = wayTo(kCutPlay + kRimBall * spacing_);
    if (way.cwiseAbs().maxCoeff() > kRimCell * spacing_) continue;  // nearer to another point
    const Vector3d at_point =
        lattice_.cornerOf(block.place) + spacing_ * Vector3d(double(point & 7), double(point >> 3 & 7), double(point >> 6));
    const Vector3d along = kRimApart / 2 * spacing_ * of_depth.cross(of_clearance).normalized();
    add(at_point + way - along);
    add(at_point + way + along);
    add(at_point + wayTo(kCutPlay + kSecondBall * spacing_));
  }
}

void LatticeWall::findNear(const CutBlock& block, const Vector3d& centre, double reach, std::uint8_t* near) const {
  WallRequest request{};
  const Vector3d corner = lattice_.cornerOf(block.place) - centre;
  for (int k = 0; k < 3; ++k) request.corner[k] = static_cast<float>(corner[k]);
  request.spacing = static_cast<float>(spacing_);
  request.reach = static_cast<float>(reach);
  request.largest = static_cast<float>(largestBall());
  request.play = static_cast<float>(kCutPlay);
  request.clearance = block.clearance;
  request.depth = block.depth;
  request.wall = block.wall;
  request.near = near;
  lattice_.kernel().nearWalls(request);
}

}  // namespace spheretree::runtime
