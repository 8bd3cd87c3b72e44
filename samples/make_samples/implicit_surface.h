// SPDX-License-Identifier: Apache-2.0
// A smooth implicit solid turned into a closed mesh of well-shaped triangles, the same bytes on every machine.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::samples {

/// Negative inside, approximately a distance near its zero set [mm]. Only + - * / and square roots, so that every
/// compiler gives the same bytes.
using Field = std::function<double(const Eigen::Vector3d&)>;

inline double squared(double x) { return x * x; }

/// Larger of `a` and `b`, rounded where they differ by less than `width`: at most width / 4 above the larger.
double smoothMax(double a, double b, double width);
/// Smaller of `a` and `b`, rounded in the same way.
double smoothMin(double a, double b, double width);
/// 0 below 0, 1 above 1, 3 t^2 - 2 t^3 between.
double smoothStep(double t);

/// Mesh of {field = 0} inside the box, which must contain the solid with a margin of one cell. `cell` [mm] is the
/// approximate length of an edge; no feature of the solid may be thinner than two cells. Method: naive surface nets (S.
/// Gibson, MICCAI 1998), then rounds of tangential smoothing, projection to the zero set and Delaunay flips. Cost:
/// O(box / cell^3) values of the field.
/// @throws std::invalid_argument if the solid reaches a face of the box.
TriangleMesh polygonise(const Field& field, const Eigen::Vector3d& low, const Eigen::Vector3d& high, double cell);

}  // namespace spheretree::samples
