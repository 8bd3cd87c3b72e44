// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/reduce_grid.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "spheretree/core/rounding.h"
#include "spheretree/core/smallest_enclosing_ball.h"

namespace spheretree::builder {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double kFinest = 0.125;            // smallest cell, as a share of the extent of the points
constexpr double kGrow = 1.189207115002721;  // ratio of the cells of consecutive grids: the fourth root of 2, so that halves occur

// Columns: the principal axes, the longest extent last.
Matrix3d principalAxes(std::span<const Vector3d> points) {
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : points) mean += p / static_cast<double>(points.size());
  Matrix3d covariance = Matrix3d::Zero();
  for (const Vector3d& p : points) covariance += (p - mean) * (p - mean).transpose();
  return Eigen::SelfAdjointEigenSolver<Matrix3d>(covariance).eigenvectors();
}

// The occupied cells of a grid that starts at `low`, as lists of points in the order of their first point. Empty as
// soon as there are more than `max_count`, which a few points show for most grids. `points`: in the axes of the grid,
// nowhere below `low` and less than twice the extent from it.
class Cells {
 public:
  explicit Cells(std::size_t max_count) : list_at_(along_ * along_ * along_, max_count), place_(max_count), points_(max_count) {}

  bool sort(std::span<const Vector3d> points, const Vector3d& low, double size) {
    for (std::size_t cell = 0; cell < count_; ++cell) list_at_[place_[cell]] = points_.size();
    count_ = 0;
    const double per_cell = 1 / size;
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      const Vector3d q = per_cell * (points[i] - low);
      const std::size_t place =
          (static_cast<std::size_t>(q.x()) * along_ + static_cast<std::size_t>(q.y())) * along_ + static_cast<std::size_t>(q.z());
      std::size_t& cell = list_at_[place];
      if (cell == points_.size()) {
        if (count_ == points_.size()) return false;
        cell = count_;
        place_[count_] = place;
        points_[count_++].clear();
      }
      points_[cell].push_back(i);
    }
    return true;
  }
  std::span<const std::vector<std::uint32_t>> lists() const { return {points_.data(), count_}; }

 private:
  const std::size_t along_ = static_cast<std::size_t>(2 / kFinest);  // cells along an axis: shifted grids reach beyond the extent
  std::size_t count_ = 0;
  std::vector<std::size_t> list_at_;  // (cells) list of a cell; as many entries as possible cells: none
  std::vector<std::size_t> place_;    // (lists) cell
  std::vector<std::vector<std::uint32_t>> points_;
};

// The smallest ball of the points of each cell; empty as soon as one has an overhang of more than `max_overhang`.
std::vector<FittedBall> ballsOf(const Cells& cells, const Region& region, double max_overhang, std::vector<Vector3d>& in_cell) {
  std::vector<FittedBall> balls;
  for (const std::vector<std::uint32_t>& list : cells.lists()) {
    in_cell.clear();
    for (const std::uint32_t i : list) in_cell.push_back(region.points[i]);
    const Ball ball = smallestEnclosing(in_cell);
    // The distance of the centre to the surface is at most that to the nearest of the points. This excludes most grids
    // without a distance query.
    double max_clearance2 = std::numeric_limits<double>::infinity();
    for (const Vector3d& p : in_cell) max_clearance2 = std::min(max_clearance2, (p - ball.centre).squaredNorm());
    if (ball.radius - std::sqrt(max_clearance2) > max_overhang) return {};
    balls.push_back({ball.centre, ball.radius, -region.field.signedDistance(ball.centre)});
    if (balls.back().overhang() > max_overhang) return {};
  }
  return balls;
}

}  // namespace

std::vector<FittedBall> reduceGrid(const Region& region) {
  if (region.points.empty()) return {};
  const Matrix3d axes = principalAxes(region.points);
  std::vector<Matrix3d> turns{axes, Matrix3d::Identity()};  // a cube has no distinct principal axes
  for (int k = 0; k < 3; ++k) turns.push_back(Eigen::AngleAxisd(std::numbers::pi / 4, axes.col(k)).toRotationMatrix() * axes);
  // One ball: in a rod it is better than cells on all sides of it.
  const Ball whole = smallestEnclosing(region.points);
  std::vector<FittedBall> best{{whole.centre, whole.radius, -region.field.signedDistance(whole.centre)}};
  double smallest = best[0].overhang();
  if (smallest <= region.target_overhang) return best;
  std::vector<Vector3d> turned(region.points.size()), in_cell;
  Cells cells(region.max_balls);
  for (const Matrix3d& turn : turns) {
    Eigen::AlignedBox3d box;
    for (std::size_t i = 0; i < turned.size(); ++i) {
      turned[i] = turn.transpose() * region.points[i];
      box.extend(turned[i]);
    }
    const double extent = box.sizes().maxCoeff() * (1 + kRounding);  // the halves of a cube are two cells, whatever the rounding
    if (!(extent > 0)) return {{region.points.front(), 0, 0}};
    for (int offset = 0; offset < 8; ++offset) {
      const Vector3d shift(offset & 1 ? 0.5 : 0, offset & 2 ? 0.5 : 0, offset & 4 ? 0.5 : 0);
      for (double size = kFinest * extent; size < kGrow * extent; size *= kGrow) {
        if (!cells.sort(turned, box.min() - size * shift, size)) continue;
        std::vector<FittedBall> balls = ballsOf(cells, region, std::max(smallest, region.target_overhang), in_cell);
        if (balls.empty()) continue;
        double worst = 0;
        for (const FittedBall& ball : balls) worst = std::max(worst, ball.overhang());
        if (smallest > region.target_overhang ? worst < smallest : balls.size() < best.size()) smallest = worst, best = std::move(balls);
      }
    }
  }
  return best;
}

}  // namespace spheretree::builder
