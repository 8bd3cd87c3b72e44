// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/octree_for_tolerance.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>
#include <utility>
#include <vector>

#include "medial/shrinking_balls.h"
#include "published/octree_cells.h"
#include "spheretree/core/smallest_enclosing_ball.h"
#include "tree/hierarchy.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kCellsALeaf = 16;  // for a tolerance: number of cells for each leaf, before they are joined
constexpr int kSteps = 6;                // steps of the search for the smallest overhang that the budget allows ...
constexpr double kUsedUp = 0.95;         // ... which ends when this share of the budget is used
constexpr double kNearGoal = 0.8;        // a tolerance above this share of a goal is tried itself

// ballRound(), or a ball that starts deep below the surface: for a cell much smaller than the thickness of the solid,
// that one has a far smaller overhang.
FittedBall deepBallRound(const OctreeCell& cell, const DistanceField& field) {
  const FittedBall shallow = ballRound(cell, field);
  const Polygon corners = cornersOf(cell);
  const Ball deep = touchingBall(field, smallestEnclosing(corners).centre);
  return deep.radius > 0 ? better(shallow, refittedBall(cell, corners, field, deep.centre, deep.radius)) : shallow;
}

struct FittedCell {
  OctreeCell cell;
  FittedBall ball;
};

// Cells that are halved one at a time, the one with the largest overhang first, across its longest side.
class Halving {
 public:
  Halving(const OctreeCell& root, const DistanceField& field) : field_(&field), cells_{{root, deepBallRound(root, field)}} {
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
      std::vector<OctreeCell> halves = halve(cells_[at].cell, longest);
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

OctreeCell joined(const OctreeCell& a, const OctreeCell& b) {
  OctreeCell both{a.box.merged(b.box), a.pieces};
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
void takeHeld(FittedBall& ball, double target, OctreeCell& cell) {
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
        OctreeCell both = joined(grown.cell, cells[j].cell);
        const FittedBall ball = refittedBall(both, cornersOf(both), field, grown.ball.centre, grown.ball.clearance);
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

}  // namespace

LevelBalls buildOctreeForTolerance(const TriangleMesh& mesh, const DistanceField& field, const PublishedSettings& settings,
                                   Progress& progress) {
  std::size_t budget = 1;
  for (int level = 1; level < settings.levels; ++level) budget *= static_cast<std::size_t>(settings.branching);
  const double target = std::max(settings.tolerance_mm, kNegligibleOverhang * field.diagonal());
  Halving halving(rootCell(mesh, field), field);
  const std::vector<FittedBall> leaves = findLeaves(halving, field, budget, target, progress);
  const std::vector<std::size_t> counts = levelCounts(leaves.size(), settings.branching);
  LevelBalls out;  // the levels above the leaves have as many cells as the leaves need as parents
  out.balls.resize(counts.size());
  for (std::size_t level = 0; level + 1 < counts.size(); ++level) {
    halving.run(counts[level], target, progress);
    for (const FittedCell& cell : halving.cells()) out.balls[level].push_back(cell.ball.ball());
  }
  for (const FittedBall& leaf : leaves) out.balls.back().push_back(leaf.ball());
  return out;
}

}  // namespace spheretree::builder
