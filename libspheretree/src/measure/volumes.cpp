// SPDX-License-Identifier: GPL-3.0-or-later
#include "measure/volumes.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

/// A crossing of a line with the mesh.
struct Crossing {
  double height;
  int turn;  // change of the winding number
};

struct Interval {
  double low, high;
};

/// The lines are parallel to z, through the points of a square grid, in a rotated frame.
struct Grid {
  double low_x = 0, low_y = 0, step = 1;
  int columns = 0, rows = 0;
  double x(int column) const { return low_x + (column + 0.5) * step; }
  double y(int row) const { return low_y + (row + 0.5) * step; }
  /// First column or row whose line is at or above `at`, clamped to 0..count.
  static int firstAt(double at, double low, double step, int count) {
    return static_cast<int>(std::clamp(std::ceil((at - low) / step - 0.5), 0.0, static_cast<double>(count)));
  }
};

/// Whether the line (x, y) is to the left of the edge from a to b. Exactly opposite for the edge from b to a, since
/// products and differences then only change their sign, so that a line cannot slip between two triangles. A line on
/// the edge is treated as shifted by an infinitesimal step along x, then along y.
bool isLeft(const Vector3d& a, const Vector3d& b, double x, double y) {
  const double ax = a.x() - x, ay = a.y() - y, bx = b.x() - x, by = b.y() - y;
  const double turn = ax * by - bx * ay;
  if (turn != 0) return turn > 0;
  if (a.y() != b.y()) return a.y() > b.y();
  return b.x() > a.x();
}

void crossTriangle(const Grid& grid, int row, const std::array<Vector3d, 3>& corner, std::vector<std::vector<Crossing>>& out) {
  const double y = grid.y(row);
  const auto [low_x, high_x] = std::minmax({corner[0].x(), corner[1].x(), corner[2].x()});
  const int first = std::max(0, Grid::firstAt(low_x, grid.low_x, grid.step, grid.columns) - 1);
  const int end = std::min(grid.columns, Grid::firstAt(high_x, grid.low_x, grid.step, grid.columns) + 1);
  const Vector3d normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
  for (int column = first; column < end; ++column) {
    const double x = grid.x(column);
    const bool left = isLeft(corner[0], corner[1], x, y);
    if (isLeft(corner[1], corner[2], x, y) != left || isLeft(corner[2], corner[0], x, y) != left) continue;
    // Height of the plane, clamped to the triangle's range, since nearly vertical planes are steep.
    const double z = corner[0].z() - (normal.x() * (x - corner[0].x()) + normal.y() * (y - corner[0].y())) / normal.z();
    const auto [low_z, high_z] = std::minmax({corner[0].z(), corner[1].z(), corner[2].z()});
    // Counter-clockwise seen from above: the surface faces up, and a rising line leaves the solid.
    out[static_cast<std::size_t>(column)].push_back({std::isfinite(z) ? std::clamp(z, low_z, high_z) : low_z, left ? -1 : 1});
  }
}

/// Adds an interval to disjoint intervals in ascending order. The lists stay short, since the balls of a union overlap.
void unite(std::vector<Interval>& list, Interval added) {
  const auto first = std::find_if(list.begin(), list.end(), [&](const Interval& i) { return i.high >= added.low; });
  auto last = first;
  for (; last != list.end() && last->low <= added.high; ++last) {
    added.low = std::min(added.low, last->low);
    added.high = std::max(added.high, last->high);
  }
  if (first == last) {
    list.insert(first, added);
  } else {
    *first = added;
    list.erase(first + 1, last);
  }
}

void crossBall(const Grid& grid, int row, const Ball& ball, std::vector<std::vector<Interval>>& out) {
  const double dy = grid.y(row) - ball.centre.y(), width2 = ball.radius * ball.radius - dy * dy;
  if (!(width2 > 0)) return;
  const double width = std::sqrt(width2);
  const int first = Grid::firstAt(ball.centre.x() - width, grid.low_x, grid.step, grid.columns);
  const int end = Grid::firstAt(ball.centre.x() + width, grid.low_x, grid.step, grid.columns);
  for (int column = first; column < end; ++column) {
    const double dx = grid.x(column) - ball.centre.x();
    const double half = std::sqrt(std::max(0.0, width2 - dx * dx));
    unite(out[static_cast<std::size_t>(column)], {ball.centre.z() - half, ball.centre.z() + half});
  }
}

/// Sums of lengths along lines.
struct Lengths {
  double mesh = 0, balls = 0, both = 0;

  void add(std::vector<Crossing>& crossings, const std::vector<Interval>& covered) {
    std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) { return a.height < b.height; });
    int winding = 0;
    for (const Crossing& crossing : crossings) winding += crossing.turn;
    if (winding != 0) return;  // the mesh is not closed here
    for (const Interval& i : covered) balls += i.high - i.low;
    auto next = covered.begin();
    for (std::size_t k = 0; k + 1 < crossings.size(); ++k) {
      winding += crossings[k].turn;
      if (winding == 0) continue;
      const double low = crossings[k].height, high = crossings[k + 1].height;
      mesh += high - low;
      for (; next != covered.end() && next->high <= low; ++next) {
      }
      for (auto i = next; i != covered.end() && i->low < high; ++i) both += std::min(high, i->high) - std::max(low, i->low);
    }
  }
};

// Mesh and balls in a pose without a simple relation to the axes, so that no line runs along an edge; relative to the
// middle of the mesh, so that no digits are lost far from the origin.
struct Turned {
  std::vector<Vector3d> positions;
  std::vector<Ball> balls;
  Eigen::AlignedBox3d box;
};

Turned turned(const TriangleMesh& mesh, std::span<const Ball> balls) {
  const Vector3d up = Vector3d(0.3271, 0.5449, 0.7721).normalized();
  const Vector3d side = up.cross(Vector3d(0.2113, -0.9101, 0.3571)).normalized(), back = up.cross(side);
  Eigen::AlignedBox3d mesh_box;
  for (const Vector3d& p : mesh.positions) mesh_box.extend(p);
  const Vector3d middle = mesh_box.center();
  const auto turn = [&](const Vector3d& p) -> Vector3d {
    const Vector3d q = p - middle;
    return {side.dot(q), back.dot(q), up.dot(q)};
  };
  Turned out;
  out.positions.reserve(mesh.positions.size());
  for (const Vector3d& p : mesh.positions) {
    out.positions.push_back(turn(p));
    out.box.extend(out.positions.back());
  }
  out.balls.assign(balls.begin(), balls.end());
  for (Ball& ball : out.balls) {
    ball.centre = turn(ball.centre);
    out.box.extend(ball.centre - Vector3d::Constant(ball.radius));
    out.box.extend(ball.centre + Vector3d::Constant(ball.radius));
  }
  return out;
}

Lengths sumOfRows(const TriangleMesh& mesh, const Turned& posed, const Grid& grid, int first_row, int end_row) {
  std::vector<std::array<Vector3d, 3>> triangles;  // triangles that intersect the rows
  for (const Triangle& t : mesh.triangles) {
    const Vector3d &p = posed.positions[t[0]], &q = posed.positions[t[1]], &r = posed.positions[t[2]];
    const auto [low, high] = std::minmax({p.y(), q.y(), r.y()});
    if (low <= grid.y(end_row) && high >= grid.y(first_row - 1)) triangles.push_back({p, q, r});
  }
  std::vector<std::vector<Crossing>> crossings(static_cast<std::size_t>(grid.columns));
  std::vector<std::vector<Interval>> covered(static_cast<std::size_t>(grid.columns));
  Lengths sum;
  for (int row = first_row; row < end_row; ++row) {
    const double y = grid.y(row);
    for (auto& list : crossings) list.clear();
    for (auto& list : covered) list.clear();
    for (const auto& t : triangles) {
      const auto [low, high] = std::minmax({t[0].y(), t[1].y(), t[2].y()});
      if (low <= y && high >= y) crossTriangle(grid, row, t, crossings);
    }
    for (const Ball& ball : posed.balls) crossBall(grid, row, ball, covered);
    for (std::size_t column = 0; column < crossings.size(); ++column) sum.add(crossings[column], covered[column]);
  }
  return sum;
}

}  // namespace

Volumes measureVolumes(const TriangleMesh& mesh, std::span<const Ball> balls, std::size_t lines, Progress& progress) {
  if (lines == 0) throw std::invalid_argument("volumes: at least one line");
  const Turned posed = turned(mesh, balls);
  Volumes out;
  if (posed.box.isEmpty()) return out;

  Grid grid;
  const Vector3d size = posed.box.sizes();
  grid.step = std::sqrt(std::max(size.x() * size.y(), 1e-12 * size.squaredNorm()) / static_cast<double>(lines));
  if (!(grid.step > 0)) return out;
  const double largest = static_cast<double>(4 * lines + 16);
  grid.columns = static_cast<int>(std::min(std::ceil(size.x() / grid.step) + 1, largest));
  grid.rows = static_cast<int>(std::min(std::ceil(size.y() / grid.step) + 1, largest));
  grid.low_x = posed.box.min().x() - 0.5 * grid.step;
  grid.low_y = posed.box.min().y() - 0.5 * grid.step;

  constexpr int kBands = 64;  // constant, so that the order of the sums does not depend on the threads
  std::array<Lengths, kBands> bands{};
  tbb::parallel_for(0, kBands, [&](int band) {
    if (progress.cancelled()) return;
    const int first_row = static_cast<int>(static_cast<long long>(grid.rows) * band / kBands);
    const int end_row = static_cast<int>(static_cast<long long>(grid.rows) * (band + 1) / kBands);
    bands[static_cast<std::size_t>(band)] = sumOfRows(mesh, posed, grid, first_row, end_row);
  });
  progress.check();
  Lengths sum;
  for (const Lengths& band : bands) {
    sum.mesh += band.mesh;
    sum.balls += band.balls;
    sum.both += band.both;
  }
  const double cell = grid.step * grid.step;
  out.mesh = cell * sum.mesh;
  out.balls = cell * sum.balls;
  out.excess = cell * (sum.balls - sum.both);
  out.missing = cell * (sum.mesh - sum.both);
  return out;
}

}  // namespace spheretree::builder
