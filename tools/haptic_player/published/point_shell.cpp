// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/point_shell.h"

#include <algorithm>

#include "measure/coverage.h"
#include "scenarios/scenario_shapes.h"

namespace spheretree::player {

PointShell::PointShell(const Body& tool, const Eigen::Vector3d& reference_point, std::size_t count) {
  for (const builder::SurfacePoint& p : builder::spreadOverSurface(tool.mesh, count, 1)) {
    point.push_back(p.point - reference_point);
    normal.push_back(tool.field.normal(p.triangle));
  }
  tree = BallTree(point, {});
}

PointBudget pointBudget(std::size_t bytes, std::size_t objects) {
  const std::size_t points = std::clamp<std::size_t>(bytes / 4 / PointShell::kBytes, 200, 20'000);
  const std::size_t left = bytes - std::min(bytes, points * PointShell::kBytes);
  return {points, left / std::max<std::size_t>(objects, 1)};
}

}  // namespace spheretree::player
