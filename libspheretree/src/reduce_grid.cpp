// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/reduce_grid.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "spheretree/builder/smallest_ball.h"

namespace spheretree::builder {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double kShrink = 0.9;  // of the cell, from one grid to the next

// Columns: the principal axes, the longest extent last.
Matrix3d principalAxes(std::span<const Vector3d> points) {
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : points) mean += p / static_cast<double>(points.size());
  Matrix3d covariance = Matrix3d::Zero();
  for (const Vector3d& p : points) covariance += (p - mean) * (p - mean).transpose();
  return Eigen::SelfAdjointEigenSolver<Matrix3d>(covariance).eigenvectors();
}

struct Cell {
  std::array<std::int64_t, 3> place;
  std::uint32_t point;
  auto operator<=>(const Cell&) const = default;
};

// The points of each occupied cell; empty as soon as there are more than `most`.
std::vector<std::vector<Vector3d>> sortIntoCells(std::span<const Vector3d> points, const Matrix3d& turn, const Vector3d& low, double size,
                                                 std::size_t most) {
  std::vector<Cell> cells(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const Vector3d q = (turn.transpose() * points[i] - low) / size;
    cells[i] = {{static_cast<std::int64_t>(std::floor(q.x())), static_cast<std::int64_t>(std::floor(q.y())),
                 static_cast<std::int64_t>(std::floor(q.z()))},
                i};
  }
  std::sort(cells.begin(), cells.end());
  std::vector<std::vector<Vector3d>> sorted;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i == 0 || cells[i].place != cells[i - 1].place) {
      if (sorted.size() == most) return {};
      sorted.emplace_back();
    }
    sorted.back().push_back(points[cells[i].point]);
  }
  return sorted;
}

}  // namespace

std::vector<FittedBall> reduceGrid(const Region& region) {
  if (region.points.empty()) return {};
  const Matrix3d axes = principalAxes(region.points);
  std::vector<Matrix3d> turns{axes, Matrix3d::Identity()};  // a cube has no principal axes of its own
  for (int k = 0; k < 3; ++k) turns.push_back(Eigen::AngleAxisd(std::numbers::pi / 4, axes.col(k)).toRotationMatrix() * axes);
  std::vector<FittedBall> best;
  double least = std::numeric_limits<double>::infinity();
  for (const Matrix3d& turn : turns) {
    Eigen::AlignedBox3d box;
    for (const Vector3d& p : region.points) box.extend(turn.transpose() * p);
    const double extent = box.sizes().maxCoeff() * (1 + 1e-9);
    if (!(extent > 0)) return {{region.points.front(), 0, 0}};
    bool found = true;
    for (double size = extent; found && size > 1e-3 * extent; size *= kShrink) {
      found = false;
      for (int offset = 0; offset < 8; ++offset) {
        const Vector3d shift(offset & 1 ? 0.5 : 0, offset & 2 ? 0.5 : 0, offset & 4 ? 0.5 : 0);
        const auto cells = sortIntoCells(region.points, turn, box.min() - size * shift, size, region.most);
        if (cells.empty()) continue;
        found = true;
        std::vector<FittedBall> balls;
        double worst = 0;
        for (const auto& points : cells) {
          const Ball ball = smallestBall(points);
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
