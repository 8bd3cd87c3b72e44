// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/reduce_octree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <queue>
#include <utility>
#include <vector>

#include "geometry/smallest_ball.h"
#include "medial/refit_ball.h"
#include "medial/shrinking_balls.h"
#include "medial/surface_regions.h"
#include "tree/hierarchy.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr int kRefitSteps = 24;
constexpr double kNegligibleOverhang = 1e-6;  // negligible overhang, as a share of the diagonal
constexpr std::size_t kCellsALeaf = 16;       // for a tolerance: number of cells for each leaf, before they are joined
constexpr int kSteps = 6;                     // steps of the search for the smallest overhang that the budget allows ...
constexpr double kUsedUp = 0.95;              // ... which ends when this share of the budget is used
constexpr double kNearGoal = 0.8;             // a tolerance above this share of a goal is tried itself

using Polygon = std::vector<Vector3d>;

struct Cell {
  Eigen::AlignedBox3d box;
  std::vector<Polygon> pieces;
  std::uint32_t parent = kNoParent;
};

Polygon cornersOf(const Cell& cell) {
  Polygon corners;
  for (const Polygon& piece : cell.pieces) corners.insert(corners.end(), piece.begin(), piece.end());
  return corners;
}

// Moves the centre to lower the overhang.
FittedBall refitted(const Cell& cell, const Polygon& corners, const DistanceField& field, const Vector3d& centre, double clearance) {
  const Refit refit = refitBall(field, corners, centre, clearance, 0.1 * cell.box.diagonal().norm(), kRefitSteps);
  return {refit.centre, refit.clearance + refit.stand_off, refit.clearance};
}

FittedBall better(const FittedBall& a, const FittedBall& b) { return b.overhang() < a.overhang() ? b : a; }

// The better of two balls: the smallest ball, whose centre lies on the surface where that is flat; and a ball about the
// middle of the cell, whose centre is then moved.
FittedBall ballRound(const Cell& cell, const DistanceField& field) {
  const Polygon corners = cornersOf(cell);
  const Ball smallest = smallestBall(corners);
  const FittedBall outer{smallest.centre, smallest.radius, -field.signedDistance(smallest.centre)};
  const Vector3d middle = cell.box.center();
  const double clearance = -field.signedDistance(middle);
  return clearance > 0 ? better(outer, refitted(cell, corners, field, middle, clearance)) : outer;
}

// ... or one that starts deep below the surface: for a cell much smaller than the thickness of the solid, that one has
// a far smaller overhang.
FittedBall deepBallRound(const Cell& cell, const DistanceField& field) {
  const FittedBall shallow = ballRound(cell, field);
  const Polygon corners = cornersOf(cell);
  const Ball deep = touchingBall(field, smallestBall(corners).centre);
  return deep.radius > 0 ? better(shallow, refitted(cell, corners, field, deep.centre, deep.radius)) : shallow;
}

// Both parts get exactly the same corner on the plane.
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
  // A piece that only touches the plane belongs only to the other side.
  for (Polygon& part : parts)
    if (part.size() < 3) part.clear();
  return parts;
}

// The halves that contain any piece.
std::vector<Cell> halve(const Cell& whole, int axis) {
  const double middle = whole.box.center()[axis];
  std::array<Cell, 2> half;
  half[0].box = half[1].box = whole.box;
  half[0].box.max()[axis] = half[1].box.min()[axis] = middle;
  for (const Polygon& piece : whole.pieces) {
    std::array<Polygon, 2> parts = cut(piece, axis, middle);
    // A flat piece in the plane itself would otherwise belong to both.
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

// Cells that are halved one at a time, the one with the largest overhang first, across its longest side.
class Halving {
 public:
  Halving(const Cell& root, const DistanceField& field) : field_(&field), cells_{{root, deepBallRound(root, field)}} {
    worst_.emplace(cells_[0].ball.overhang(), 0);
  }

  // Halves until no cell has an overhang above `target` or there are `max_count` cells.
  void run(std::size_t max_count, double target, Progress& progress) {
    while (cells_.size() < max_count && worst() > target) {
      progress.check();
      const std::size_t at = worst_.top().second;
      worst_.pop();
      int longest = 0;
      cells_[at].cell.box.sizes().maxCoeff(&longest);
      std::vector<Cell> halves = halve(cells_[at].cell, longest);
      for (std::size_t h = 0; h < halves.size(); ++h) {
        const FittedBall ball = deepBallRound(halves[h], *field_);
        const std::size_t to = h == 0 ? at : cells_.size();
        if (h > 0) cells_.emplace_back();
        cells_[to] = {std::move(halves[h]), ball};
        worst_.emplace(ball.overhang(), to);
      }
    }
  }
  double worst() const { return worst_.top().first; }
  const std::vector<FittedCell>& cells() const { return cells_; }

 private:
  const DistanceField* field_;
  std::vector<FittedCell> cells_;
  std::priority_queue<std::pair<double, std::size_t>> worst_;
};

Cell joined(const Cell& a, const Cell& b) {
  Cell both{a.box.merged(b.box), a.pieces};
  both.pieces.insert(both.pieces.end(), b.pieces.begin(), b.pieces.end());
  return both;
}

// For each cell, the cells that it touches.
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

// Removes the pieces of a cell that a ball with an overhang of at most `target` can contain; the ball grows as
// necessary.
void takeHeld(FittedBall& ball, double target, Cell& cell) {
  std::erase_if(cell.pieces, [&](const Polygon& piece) {
    double reach = 0;
    for (const Vector3d& p : piece) reach = std::max(reach, (p - ball.centre).norm());
    if (reach > ball.clearance + target) return false;
    ball.radius = std::max(ball.radius, reach);
    return true;
  });
}

// One after the other, cells absorb the cells that they touch, as long as one ball around all has an overhang of at
// most `target`. Pieces of other cells that the ball contains are removed from those cells. Empty if more than
// `max_count` cells remain.
std::vector<FittedBall> joinNeighbours(std::vector<FittedCell> cells, const DistanceField& field, std::size_t max_count, double target,
                                       Progress& progress) {
  const std::vector<std::vector<std::uint32_t>> near = neighbours(cells);
  std::vector<std::size_t> tried_by(cells.size(), cells.size());
  std::vector<FittedBall> out;
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    if (cells[i].cell.pieces.empty()) continue;  // absorbed
    if (out.size() == max_count) return {};
    progress.check();
    FittedCell grown = std::exchange(cells[i], {});
    std::vector<std::uint32_t> members{i}, others;
    for (std::size_t m = 0; m < members.size(); ++m)
      for (const std::uint32_t j : near[members[m]]) {
        if (cells[j].cell.pieces.empty() || tried_by[j] == i) continue;
        tried_by[j] = i;
        Cell both = joined(grown.cell, cells[j].cell);
        const FittedBall ball = refitted(both, cornersOf(both), field, grown.ball.centre, grown.ball.clearance);
        if (ball.overhang() > target) {
          others.push_back(j);
          continue;
        }
        grown = {std::move(both), ball};
        cells[j] = {};
        members.push_back(j);
      }
    for (const std::uint32_t j : others) takeHeld(grown.ball, target, cells[j].cell);
    out.push_back(grown.ball);
  }
  return out;
}

// The smallest number of balls that keeps the tolerance; if it is out of reach, the balls with the smallest overhang
// that the budget allows. The search comes from above, since cells too small for the budget are the most expensive.
std::vector<FittedBall> findLeaves(Halving halving, const DistanceField& field, std::size_t budget, double tolerance, Progress& progress) {
  halving.run(budget, tolerance, progress);
  double low = 0, high = std::max(halving.worst(), tolerance);
  std::vector<FittedBall> leaves = joinNeighbours(halving.cells(), field, budget, high, progress);
  for (int step = 0; step < kSteps && high > tolerance; ++step) {
    const double used = static_cast<double>(leaves.size()) / static_cast<double>(budget);
    double goal = std::max(std::sqrt(used) * high, std::sqrt(low * high));
    if (tolerance > low && tolerance > kNearGoal * goal)
      goal = tolerance;
    else if (used > kUsedUp)
      break;
    Halving finer = halving;
    finer.run(kCellsALeaf * budget, goal, progress);
    std::vector<FittedBall> tried;
    if (finer.worst() <= goal) tried = joinNeighbours(finer.cells(), field, budget, goal, progress);
    if (tried.empty()) {
      low = goal;
    } else {
      high = goal;
      leaves = std::move(tried);
      halving = std::move(finer);
    }
  }
  return leaves;
}

// The levels above have as many cells as the leaves need as parents.
LevelBalls buildForTolerance(const Cell& root, const DistanceField& field, const PublishedSettings& settings, Progress& progress) {
  std::size_t budget = 1;
  for (int level = 1; level < settings.levels; ++level) budget *= static_cast<std::size_t>(settings.branching);
  const double target = std::max(settings.tolerance_mm, kNegligibleOverhang * field.diagonal());
  Halving halving(root, field);
  const std::vector<FittedBall> leaves = findLeaves(halving, field, budget, target, progress);
  const std::vector<std::size_t> counts = levelCounts(leaves.size(), settings.branching);
  LevelBalls out;
  out.balls.resize(counts.size());
  for (std::size_t level = 0; level + 1 < counts.size(); ++level) {
    halving.run(counts[level], target, progress);
    for (const FittedCell& cell : halving.cells()) out.balls[level].push_back(cell.ball.ball());
  }
  for (const FittedBall& leaf : leaves) out.balls.back().push_back(leaf.ball());
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
      if (level + 1 == settings.levels || ball.overhang() <= kNegligibleOverhang * field.diagonal()) continue;
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
