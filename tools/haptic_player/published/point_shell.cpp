// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/point_shell.h"

#include <algorithm>

#include "measure/coverage.h"

namespace spheretree::player {

PointShell::PointShell(const Body& tool, const Eigen::Vector3d& reference_point, std::size_t count) {
  for (const builder::SurfacePoint& p : builder::spreadOverSurface(tool.mesh, count, 1)) {
    point.push_back(p.point - reference_point);
    normal.push_back(tool.field.normal(p.triangle));
  }
  tree = BallTree(point, {});
}

PointModel::PointModel(const RendererScene& scene)
    : shell(*scene.tool, scene.reference_point, std::clamp<std::size_t>(scene.bytes / 4 / PointShell::kBytes, 200, 20'000)) {
  const std::size_t left = scene.bytes - std::min(scene.bytes, shell.point.size() * PointShell::kBytes);
  for (const PlacedBody& object : scene.objects) grids.emplace_back(object.body->field, left / scene.objects.size());
}

}  // namespace spheretree::player
