// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/reduce_octree.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "published/octree_cells.h"
#include "spheretree/core/rounding.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

std::vector<OctreeCell> divide(OctreeCell cell, int halvings) {
  const Vector3d sizes = cell.box.sizes();
  std::array<int, 3> axes{0, 1, 2};
  std::stable_sort(axes.begin(), axes.end(), [&](int a, int b) { return sizes[a] > sizes[b]; });
  std::vector<OctreeCell> cells{std::move(cell)};
  for (int k = 0; k < halvings; ++k) {
    std::vector<OctreeCell> halves;
    for (const OctreeCell& whole : cells)
      for (OctreeCell& half : halve(whole, axes[static_cast<std::size_t>(k)])) halves.push_back(std::move(half));
    cells = std::move(halves);
  }
  return cells;
}

FittedBall ballRound(const OctreeCell& cell, const DistanceField& field) {
  const Vector3d middle = cell.box.center();
  return {middle, 0.5 * cell.box.diagonal().norm() * (1 + kRounding), -field.signedDistance(middle)};
}

}  // namespace

LevelBalls buildOctree(const TriangleMesh& mesh, const DistanceField& field, const BuildSettings& settings, Progress& progress) {
  const int halvings = settings.branching == 8 ? 3 : settings.branching >= 4 ? 2 : 1;
  std::vector<OctreeCell> cells{rootCell(mesh, field)};
  LevelBalls out;
  for (int level = 0; level < settings.levels && !cells.empty(); ++level) {
    out.balls.emplace_back();
    out.parents.emplace_back();
    std::vector<OctreeCell> next;
    for (OctreeCell& cell : cells) {
      progress.check();
      const FittedBall ball = ballRound(cell, field);
      out.balls.back().push_back(ball.ball());
      out.parents.back().push_back(cell.parent);
      if (level + 1 == settings.levels || ball.overhang() <= settings.tolerance_mm) continue;
      const auto parent = static_cast<std::uint32_t>(out.balls.back().size() - 1);
      for (OctreeCell& child : divide(std::move(cell), halvings)) {
        child.parent = parent;
        next.push_back(std::move(child));
      }
    }
    cells = std::move(next);
  }
  return out;
}

}  // namespace spheretree::builder
