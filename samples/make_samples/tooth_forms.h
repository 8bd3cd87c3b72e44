// SPDX-License-Identifier: Apache-2.0
// The forms of teeth as closed meshes of 4,000 triangles.
#pragma once

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::samples {

enum class ToothForm { Incisor, Canine, Premolar, Molar };
inline constexpr std::size_t kToothTriangles = 4000;

/// Closed, manifold, genus 0. Frame [mm] as in makeMolar(): x to the front (mesial), y to the cheek (buccal), z up to
/// the biting edge or chewing surface, z = 0 near the cervical line. The width of a crown along x is crownWidth().
TriangleMesh makeTooth(ToothForm form);
double crownWidth(ToothForm form);  // [mm]

/// Corners of a circle: unit vectors counter-clockwise, the first along +x. `quarter`: corners in a quarter turn. By
/// square roots only, so that every machine gives the same bits; spaced evenly within 10 %.
std::vector<Eigen::Vector2d> circleCorners(int quarter);

}  // namespace spheretree::samples
