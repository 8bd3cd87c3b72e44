// SPDX-License-Identifier: GPL-3.0-or-later
#include "cut/solid_in_cell.h"

#include <cmath>
#include <limits>
#include <vector>

#include "spheretree/core/rounding.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

/// The part of a triangle in the cube around the origin, as a polygon. Clipped at a slightly larger cube.
void clipToCube(std::vector<Vector3d>& polygon, double half) {
  std::vector<Vector3d> kept;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      kept.clear();
      for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vector3d &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
        const double a = side * p[axis] - half, b = side * q[axis] - half;
        if (a <= 0) kept.push_back(p);
        if ((a <= 0) != (b <= 0)) kept.push_back(p + a / (a - b) * (q - p));
      }
      polygon.swap(kept);
      if (polygon.empty()) return;
    }
}

enum class Side { None, In, Out, Unknown };  // None: nothing of the cube lies there

/// One side of the slab: where the solid's state is known.
struct Region {
  Side side;
  HalfSpace half_space;
  double reach;  // how far the cube extends on this side [mm]
};

/// The set of the regions on whose side it certainly is, and of those where it may be.
CellBounds boundsOf(const Region& below, const Region& above, Side in, Side out) {
  const auto opposite = [](const HalfSpace& h) { return HalfSpace{-h.normal, -h.offset}; };
  CellBounds bounds;
  const Region* inner = nullptr;
  for (const Region* region : {&below, &above})
    if (region->side == in && (!inner || region->reach > inner->reach)) inner = region;
  bounds.inner.is_empty = !inner;
  if (inner) bounds.inner.half_spaces[static_cast<std::size_t>(bounds.inner.count++)] = inner->half_space;
  for (const Region* region : {&below, &above})
    if (region->side == out) bounds.outer.half_spaces[static_cast<std::size_t>(bounds.outer.count++)] = opposite(region->half_space);
  return bounds;
}

}  // namespace

SolidInCell wholeCell(bool is_inside) {
  const CellPart all{}, none{.is_empty = true};
  const CellBounds yes{all, all}, no{none, none};
  return is_inside ? SolidInCell{yes, no} : SolidInCell{no, yes};
}

SolidInCell boundSolid(const DistanceField& solid, const Vector3d& centre, double half) {
  const double reach = std::sqrt(3.0) * half, margin = kRounding * (half + centre.cwiseAbs().maxCoeff());
  if (const double distance = solid.signedDistance(centre); std::abs(distance) > reach + margin) return wholeCell(distance < 0);
  std::vector<Vector3d> met;  // corners of what the cube holds of the surface
  Vector3d normal = Vector3d::Zero();
  std::vector<Vector3d> polygon;
  solid.visitNear(centre, reach + margin, [&](std::uint32_t triangle) {
    polygon.clear();
    for (const Vector3d& corner : solid.corners(triangle)) polygon.push_back(corner - centre);
    clipToCube(polygon, half + margin);
    for (std::size_t k = 1; k + 1 < polygon.size(); ++k) normal += (polygon[k] - polygon[0]).cross(polygon[k + 1] - polygon[0]);
    met.insert(met.end(), polygon.begin(), polygon.end());
  });
  const auto stateAt = [&](const Vector3d& p) {
    const double distance = solid.signedDistance(centre + p);
    return std::abs(distance) <= margin ? Side::Unknown : distance < 0 ? Side::In : Side::Out;
  };
  if (met.empty()) {
    const Side state = stateAt(Vector3d::Zero());
    return state == Side::Unknown ? SolidInCell{{{.is_empty = true}, {}}, {{.is_empty = true}, {}}} : wholeCell(state == Side::In);
  }
  if (!(normal.norm() > 0)) normal = Vector3d::UnitZ();
  normal.normalize();
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vector3d& p : met) low = std::min(low, normal.dot(p)), high = std::max(high, normal.dot(p));
  low -= margin, high += margin;
  const Vector3d top = half * normal.array().sign().matrix();  // the corner of the cube that is farthest along the normal
  const double extent = normal.dot(top);
  Region below{Side::None, {normal, -low}, extent + low}, above{Side::None, {-normal, high}, extent - high};
  if (below.reach > margin) below.side = stateAt(-top);
  if (above.reach > margin) above.side = stateAt(top);
  return {boundsOf(below, above, Side::In, Side::Out), boundsOf(below, above, Side::Out, Side::In)};
}

}  // namespace spheretree::builder
