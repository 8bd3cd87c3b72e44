// SPDX-License-Identifier: GPL-3.0-or-later
// Arrows, arcs, coils and discs as triangles, created again for each picture. Units: mm; world frame.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "model/stage.h"

namespace spheretree::view {

struct ShapeCorner {
  Eigen::Vector3f position, normal;
  Colour colour;
};
static_assert(sizeof(ShapeCorner) == 28);

/// Three corners for each triangle.
using Shapes = std::vector<ShapeCorner>;

/// A shaft of `radius` with a head; the tip is at from + along.
void addArrow(Shapes& shapes, const Eigen::Vector3d& from, const Eigen::Vector3d& along, double radius, Colour colour);
/// Part of a circle about `axis` with an arrow head at its end, counter-clockwise as seen against the axis. `angle` in
/// (0, 2 pi).
void addArc(Shapes& shapes, const Eigen::Vector3d& centre, const Eigen::Vector3d& axis, double circle, double angle, double radius,
            Colour colour);
/// A wire wound around the line between two points: a spring.
void addCoil(Shapes& shapes, const Eigen::Vector3d& from, const Eigen::Vector3d& to, double coil, double wire, Colour colour);
/// A flat disc, visible from both sides.
void addDisc(Shapes& shapes, const Eigen::Vector3d& centre, const Eigen::Vector3d& normal, double radius, Colour colour);
/// A flat ring, visible from both sides.
void addRing(Shapes& shapes, const Eigen::Vector3d& centre, const Eigen::Vector3d& normal, double inner, double outer, Colour colour);
/// A rod between two points, closed at both ends.
void addRod(Shapes& shapes, const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius, Colour colour);
void addBall(Shapes& shapes, const Eigen::Vector3d& centre, double radius, Colour colour);

/// Length of a force's arrow on a logarithmic scale: 0 at 0.1 N and below, 1 at 10 N and above.
double arrowShare(double newtons);

}  // namespace spheretree::view
