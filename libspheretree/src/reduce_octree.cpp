// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/reduce_octree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <queue>
#include <utility>
#include <vector>

#include "spheretree/builder/hierarchy.h"
#include "spheretree/builder/refit_ball.h"
#include "spheretree/builder/smallest_ball.h"
#include "spheretree/builder/surface_regions.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr int kRefitSteps = 24;
constexpr double kNegligible = 1e-6;     // overhang, of the diagonal
constexpr int kSteps = 4;                // towards the least overhang, if the tolerance is out of reach
constexpr std::size_t kCellsALeaf = 16;  // for a tolerance: so many may be joined

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

// The halves that hold any piece.
std::vector<Cell> halve(const Cell& whole, int axis) {
  const double middle = whole.box.center()[axis];
  std::array<Cell, 2> half;
  half[0].box = half[1].box = whole.box;
  half[0].box.max()[axis] = half[1].box.min()[axis] = middle;
  for (const Polygon& piece : whole.pieces) {
    std::array<Polygon, 2> parts = cut(piece, axis, middle);
    // A flat piece in the plane itself would go to both.
    if (!parts[0].empty() && !parts[1].empty() &&
        std::all_of(piece.begin(), piece.end(), [&](const Vector3d& p) { return p[axis] == middle; }))
      parts[1].clear();
    for (std::size_t s = 0; s < 2; ++s)
      if (!parts[s].empty()) half[s].pieces.push_back(std::move(parts[s]));
  }
  std::vector<Cell> halves;
  for (Cell& h : half)
    if (!h.pieces.empty()) halves.push_back(std::move(h));
  return halves;
}

std::vector<Cell> divide(Cell cell, int halvings) {
  const Vector3d sizes = cell.box.sizes();
  std::array<int, 3> axes{0, 1, 2};
  std::stable_sort(axes.begin(), axes.end(), [&](int a, int b) { return sizes[a] > sizes[b]; });
  std::vector<Cell> cells{std::move(cell)};
  for (int k = 0; k < halvings; ++k) {
    std::vector<Cell> halves;
    for (const Cell& whole : cells)
      for (Cell& half : halve(whole, axes[static_cast<std::size_t>(k)])) halves.push_back(std::move(half));
    cells = std::move(halves);
  }
  return cells;
}

struct FittedCell {
  Cell cell;
  FittedBall ball;
};

// Halves the cell that reaches out farthest, across its longest side, until none reaches out farther than `enough` or there are `most`.
std::vector<FittedCell> halveWorst(const Cell& root, const DistanceField& field, std::size_t most, double enough, Progress& progress) {
  std::vector<FittedCell> cells{{root, ballRound(root, field)}};
  std::priority_queue<std::pair<double, std::size_t>> worst;
  worst.emplace(cells[0].ball.overhang(), 0);
  while (cells.size() < most && worst.top().first > enough) {
    progress.check();
    const std::size_t at = worst.top().second;
    worst.pop();
    int longest = 0;
    cells[at].cell.box.sizes().maxCoeff(&longest);
    std::vector<Cell> halves = halve(cells[at].cell, longest);
    for (std::size_t h = 0; h < halves.size(); ++h) {
      const FittedBall ball = ballRound(halves[h], field);
      const std::size_t to = h == 0 ? at : cells.size();
      if (h > 0) cells.emplace_back();
      cells[to] = {std::move(halves[h]), ball};
      worst.emplace(ball.overhang(), to);
    }
  }
  return cells;
}

double worstOverhang(const std::vector<FittedCell>& cells) {
  double worst = 0;
  for (const FittedCell& cell : cells) worst = std::max(worst, cell.ball.overhang());
  return worst;
}

Cell joined(const Cell& a, const Cell& b) {
  Cell both{a.box.merged(b.box), a.pieces};
  both.pieces.insert(both.pieces.end(), b.pieces.begin(), b.pieces.end());
  return both;
}

// Of each cell, those that it touches.
std::vector<std::vector<std::uint32_t>> neighbours(const std::vector<FittedCell>& cells) {
  std::vector<std::uint32_t> by_low(cells.size());
  std::iota(by_low.begin(), by_low.end(), 0u);
  std::stable_sort(by_low.begin(), by_low.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return cells[a].cell.box.min().x() < cells[b].cell.box.min().x(); });
  std::vector<std::vector<std::uint32_t>> near(cells.size());
  for (std::size_t i = 0; i < by_low.size(); ++i) {
    const Eigen::AlignedBox3d& box = cells[by_low[i]].cell.box;
    for (std::size_t k = i + 1; k < by_low.size() && cells[by_low[k]].cell.box.min().x() <= box.max().x(); ++k) {
      if (!box.intersects(cells[by_low[k]].cell.box)) continue;
      near[by_low[i]].push_back(by_low[k]);
      near[by_low[k]].push_back(by_low[i]);
    }
  }
  return near;
}

// Takes from a cell what a ball holds that may reach out by `enough`; the ball grows as it needs.
void takeHeld(FittedBall& ball, double enough, Cell& cell) {
  std::erase_if(cell.pieces, [&](const Polygon& piece) {
    double reach = 0;
    for (const Vector3d& p : piece) reach = std::max(reach, (p - ball.centre).norm());
    if (reach > ball.clearance + enough) return false;
    ball.radius = std::max(ball.radius, reach);
    return true;
  });
}

// One after the other, cells grow over those that they touch, as long as one ball round all reaches out no farther than `enough`. What the
// ball then holds of others is no longer theirs.
std::vector<FittedCell> joinNeighbours(std::vector<FittedCell> cells, const DistanceField& field, double enough, Progress& progress) {
  const std::vector<std::vector<std::uint32_t>> near = neighbours(cells);
  std::vector<std::size_t> tried_by(cells.size(), cells.size());
  std::vector<FittedCell> out;
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    if (cells[i].cell.pieces.empty()) continue;  // taken
    progress.check();
    FittedCell grown = std::exchange(cells[i], {});
    std::vector<std::uint32_t> members{i}, others;
    for (std::size_t m = 0; m < members.size(); ++m)
      for (const std::uint32_t j : near[members[m]]) {
        if (cells[j].cell.pieces.empty() || tried_by[j] == i) continue;
        tried_by[j] = i;
        Cell both = joined(grown.cell, cells[j].cell);
        const FittedBall ball = ballRound(both, field);
        if (ball.overhang() > enough) {
          others.push_back(j);
          continue;
        }
        grown = {std::move(both), ball};
        cells[j] = {};
        members.push_back(j);
      }
    for (const std::uint32_t j : others) takeHeld(grown.ball, enough, cells[j].cell);
    out.push_back(std::move(grown));
  }
  return out;
}

// The fewest cells that keep the tolerance, and as many above them as they need as parents.
LevelBalls buildForTolerance(const Cell& root, const DistanceField& field, const PublishedSettings& settings, Progress& progress) {
  std::size_t budget = 1;
  for (int level = 1; level < settings.levels; ++level) budget *= static_cast<std::size_t>(settings.branching);
  const double enough = std::max(settings.tolerance_mm, kNegligible * field.diagonal());
  const auto leavesFor = [&](double overhang) {
    return joinNeighbours(halveWorst(root, field, kCellsALeaf * budget, overhang, progress), field, overhang, progress);
  };
  std::vector<FittedCell> leaves = leavesFor(enough);
  if (leaves.size() > budget) {  // out of reach: the least overhang that the budget suffices for
    leaves = halveWorst(root, field, budget, enough, progress);
    double low = enough, high = worstOverhang(leaves);
    for (int step = 0; step < kSteps; ++step) {
      const double middle = std::sqrt(low * high);
      std::vector<FittedCell> tried = leavesFor(middle);
      if (tried.size() > budget || worstOverhang(tried) >= high) {
        low = middle;
      } else {
        high = worstOverhang(tried);
        leaves = std::move(tried);
      }
    }
  }
  const std::vector<std::size_t> counts = levelCounts(leaves.size(), settings.branching);
  LevelBalls out;
  const auto add = [&](const std::vector<FittedCell>& cells) {
    out.balls.emplace_back();
    for (const FittedCell& cell : cells) out.balls.back().push_back(cell.ball.ball());
  };
  for (std::size_t level = 0; level + 1 < counts.size(); ++level) add(halveWorst(root, field, counts[level], enough, progress));
  add(leaves);
  return out;
}

}  // namespace

LevelBalls buildOctree(const TriangleMesh& mesh, const DistanceField& field, const PublishedSettings& settings, Progress& progress) {
  checkSettings(settings);
  const int halvings = settings.branching == 8 ? 3 : settings.branching >= 4 ? 2 : 1;
  std::vector<Cell> cells(1);
  cells[0].box = field.box();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    cells[0].pieces.push_back({mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)});
  if (settings.tolerance_mm > 0) return buildForTolerance(cells[0], field, settings, progress);
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
      if (level + 1 == settings.levels || ball.overhang() <= kNegligible * field.diagonal()) continue;
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
