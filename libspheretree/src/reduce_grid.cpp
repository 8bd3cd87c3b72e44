// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/reduce_grid.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "spheretree/builder/smallest_ball.h"

namespace spheretree::builder {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double kShrink = 0.9;               // of the cell, from one grid to the next
constexpr double kFinest = 1e-3;              // cell, of the extent of the points
constexpr std::int64_t kMostCells = 1 << 20;  // along an axis; there are 1 / kFinest

// Columns: the principal axes, the longest extent last.
Matrix3d principalAxes(std::span<const Vector3d> points) {
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : points) mean += p / static_cast<double>(points.size());
  Matrix3d covariance = Matrix3d::Zero();
  for (const Vector3d& p : points) covariance += (p - mean) * (p - mean).transpose();
  return Eigen::SelfAdjointEigenSolver<Matrix3d>(covariance).eigenvectors();
}

struct Cell {
  std::int64_t place;  // its three numbers along the axes in one: the search is for few cells, over and over
  std::vector<Vector3d> points;
};

// The occupied cells in order of place, each with its points; none as soon as there are more than `most`: of most grids a few points show
// that. `turned`: the points in the axes of the grid, which starts at `low`.
std::vector<Cell> sortIntoCells(std::span<const Vector3d> points, std::span<const Vector3d> turned, const Vector3d& low, double size,
                                std::size_t most) {
  std::vector<Cell> cells;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Array3d q = ((turned[i] - low) / size).array().floor();
    const std::int64_t place =
        (static_cast<std::int64_t>(q.x()) * kMostCells + static_cast<std::int64_t>(q.y())) * kMostCells + static_cast<std::int64_t>(q.z());
    auto at = std::find_if(cells.begin(), cells.end(), [&](const Cell& cell) { return cell.place == place; });
    if (at == cells.end()) {
      if (cells.size() == most) return {};
      at = cells.insert(at, {place, {}});
    }
    at->points.push_back(points[i]);
  }
  std::sort(cells.begin(), cells.end(), [](const Cell& x, const Cell& y) { return x.place < y.place; });
  return cells;
}

}  // namespace

std::vector<FittedBall> reduceGrid(const Region& region) {
  if (region.points.empty()) return {};
  const Matrix3d axes = principalAxes(region.points);
  std::vector<Matrix3d> turns{axes, Matrix3d::Identity()};  // a cube has no principal axes of its own
  for (int k = 0; k < 3; ++k) turns.push_back(Eigen::AngleAxisd(std::numbers::pi / 4, axes.col(k)).toRotationMatrix() * axes);
  std::vector<FittedBall> best;
  double least = std::numeric_limits<double>::infinity();
  std::vector<Vector3d> turned(region.points.size());
  for (const Matrix3d& turn : turns) {
    Eigen::AlignedBox3d box;
    for (std::size_t i = 0; i < turned.size(); ++i) {
      turned[i] = turn.transpose() * region.points[i];
      box.extend(turned[i]);
    }
    const double extent = box.sizes().maxCoeff() * (1 + 1e-9);
    if (!(extent > 0)) return {{region.points.front(), 0, 0}};
    bool found = true;
    for (double size = extent; found && size > kFinest * extent; size *= kShrink) {
      found = false;
      for (int offset = 0; offset < 8; ++offset) {
        const Vector3d shift(offset & 1 ? 0.5 : 0, offset & 2 ? 0.5 : 0, offset & 4 ? 0.5 : 0);
        const auto cells = sortIntoCells(region.points, turned, box.min() - size * shift, size, region.most);
        if (cells.empty()) continue;
        found = true;
        std::vector<FittedBall> balls;
        double worst = 0;
        for (const Cell& cell : cells) {
          const Ball ball = smallestBall(cell.points);
          balls.push_back({ball.centre, -region.field.signedDistance(ball.centre), ball.radius});
          worst = std::max(worst, balls.back().overhang());
          if (worst >= least) break;
        }
        if (worst < least) least = worst, best = std::move(balls);
        if (least <= region.enough) return best;  // from coarse to fine: the first that will do has few balls
      }
    }
  }
  return best;
}

}  // namespace spheretree::builder
