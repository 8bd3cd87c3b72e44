// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/reduce_octree.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "spheretree/builder/refit_ball.h"
#include "spheretree/builder/smallest_ball.h"
#include "spheretree/builder/surface_regions.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr int kRefitSteps = 24;

using Polygon = std::vector<Vector3d>;

struct Cell {
  Eigen::AlignedBox3d box;
  std::vector<Polygon> pieces;
  std::uint32_t parent = kNoParent;
};

// The better of the smallest ball, whose centre lies on the surface where that is flat, and a ball about the middle of the cell,
// from where the centre moves to lower the overhang.
FittedBall ballRound(const Cell& cell, const DistanceField& field) {
  Polygon corners;
  for (const Polygon& piece : cell.pieces) corners.insert(corners.end(), piece.begin(), piece.end());
  const Ball smallest = smallestBall(corners);
  const FittedBall outer{smallest.centre, -field.signedDistance(smallest.centre), smallest.radius};
  const Vector3d middle = cell.box.center();
  const double clearance = -field.signedDistance(middle);
  if (!(clearance > 0)) return outer;
  const Refit refit = refitBall(field, corners, middle, clearance, 0.1 * cell.box.diagonal().norm(), kRefitSteps);
  const FittedBall inner{refit.centre, refit.clearance, refit.clearance + refit.stand_off};
  return inner.overhang() < outer.overhang() ? inner : outer;
}

// Both parts get the very same corner on the plane.
std::array<Polygon, 2> cut(const Polygon& piece, int axis, double at) {
  std::array<Polygon, 2> parts;
  for (std::size_t i = 0; i < piece.size(); ++i) {
    const Vector3d &a = piece[i], &b = piece[(i + 1) % piece.size()];
    const double da = a[axis] - at, db = b[axis] - at;
    if (da <= 0) parts[0].push_back(a);
    if (da >= 0) parts[1].push_back(a);
    if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
      Vector3d p = a + (da / (da - db)) * (b - a);
      p[axis] = at;
      parts[0].push_back(p);
      parts[1].push_back(p);
    }
  }
  // A piece that only touches the plane belongs to the other side alone.
  for (Polygon& part : parts)
    if (part.size() < 3) part.clear();
  return parts;
}

std::vector<Cell> divide(Cell cell, int halvings) {
  const Vector3d middle = cell.box.center(), sizes = cell.box.sizes();
  std::array<int, 3> axes{0, 1, 2};
  std::stable_sort(axes.begin(), axes.end(), [&](int a, int b) { return sizes[a] > sizes[b]; });
  std::vector<Cell> cells{std::move(cell)};
  for (int k = 0; k < halvings; ++k) {
    const int axis = axes[static_cast<std::size_t>(k)];
    std::vector<Cell> halves;
    for (const Cell& whole : cells) {
      std::array<Cell, 2> half;
      half[0].box = half[1].box = whole.box;
      half[0].box.max()[axis] = half[1].box.min()[axis] = middle[axis];
      for (const Polygon& piece : whole.pieces) {
        std::array<Polygon, 2> parts = cut(piece, axis, middle[axis]);
        // A flat piece in the plane itself would go to both.
        if (!parts[0].empty() && !parts[1].empty() &&
            std::all_of(piece.begin(), piece.end(), [&](const Vector3d& p) { return p[axis] == middle[axis]; }))
          parts[1].clear();
        for (std::size_t s = 0; s < 2; ++s)
          if (!parts[s].empty()) half[s].pieces.push_back(std::move(parts[s]));
      }
      for (Cell& h : half)
        if (!h.pieces.empty()) halves.push_back(std::move(h));
    }
    cells = std::move(halves);
  }
  return cells;
}

}  // namespace

LevelBalls buildOctree(const TriangleMesh& mesh, const DistanceField& field, const PublishedSettings& settings, Progress& progress) {
  checkSettings(settings);
  const int halvings = settings.branching == 8 ? 3 : settings.branching >= 4 ? 2 : 1;
  const double enough = std::max(settings.tolerance_mm, 1e-6 * field.diagonal());
  std::vector<Cell> cells(1);
  cells[0].box = field.box();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    cells[0].pieces.push_back({mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)});
  LevelBalls out;
  for (int level = 0; level < settings.levels && !cells.empty(); ++level) {
    out.balls.emplace_back();
    out.parents.emplace_back();
    std::vector<Cell> next;
    for (Cell& cell : cells) {
      progress.check();
      const FittedBall ball = ballRound(cell, field);
      out.balls.back().push_back(ball.ball());
      out.parents.back().push_back(cell.parent);
      if (level + 1 == settings.levels || ball.overhang() <= enough) continue;
      const auto parent = static_cast<std::uint32_t>(out.balls.back().size() - 1);
      for (Cell& child : divide(std::move(cell), halvings)) {
        child.parent = parent;
        next.push_back(std::move(child));
      }
    }
    cells = std::move(next);
  }
  return out;
}

}  // namespace spheretree::builder
