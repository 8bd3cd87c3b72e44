// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/move_apart.h"

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "split/scan_surface.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kClear = 0.1;      // distance of a sheet from what it crossed, in mean edges of its border
constexpr int kMovesAHalving = 10;  // rounds after which triangles that still cross are halved

using Edge = std::pair<std::uint32_t, std::uint32_t>;  // the lower vertex first
using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// Inserts a vertex in the middle of an edge.
void splitEdge(std::vector<Vector3d>& positions, MovableSheet& sheet, const Edge& edge) {
  const auto middle = static_cast<std::uint32_t>(positions.size());
  const Vector3d p = (positions[edge.first] + positions[edge.second]) / 2;
  positions.push_back(p);
  for (std::size_t i = sheet.triangles.size(); i-- > 0;)
    for (std::size_t k = 0; k < 3; ++k) {
      const Triangle t = sheet.triangles[i];
      if (Edge(std::minmax(t[k], t[(k + 1) % 3])) != edge) continue;
      sheet.triangles.push_back({middle, t[(k + 1) % 3], t[(k + 2) % 3]});
      sheet.group.push_back(sheet.group[i]);
      sheet.triangles[i][(k + 1) % 3] = middle;
      break;
    }
}

class Moving {
 public:
  Moving(std::vector<Vector3d>& positions, MovableSheet& sheet, const CrossingSearch& search,
         const std::function<Vector3d(std::uint32_t)>& outOf)
      : positions_(positions), sheet_(sheet), search_(search), outOf_(outOf) {}

  std::size_t run() {
    const auto first = static_cast<std::ptrdiff_t>(sheet_.first_new);
    std::vector<Vector3d> best_positions;
    MovableSheet best;
    std::size_t fewest = std::numeric_limits<std::size_t>::max();
    for (int round = 0, best_round = 0; fewest > 0 && round < best_round + kMaxRounds; ++round) {
      const Pairs pairs = search_.against(sheet_.triangles);
      if (pairs.size() < fewest) {
        fewest = pairs.size();
        best_round = round;
        best_positions.assign(positions_.begin() + first, positions_.end());
        best = sheet_;
      }
      if (round % kMovesAHalving == kMovesAHalving - 1)
        halveCrossing(pairs);
      else
        moveOnce(pairs);
    }
    positions_.resize(sheet_.first_new);
    positions_.insert(positions_.end(), best_positions.begin(), best_positions.end());
    sheet_ = std::move(best);
    return fewest;
  }

 private:
  void moveOnce(const Pairs& pairs) {
    const std::size_t first = sheet_.first_new;
    const auto old_count = static_cast<std::uint32_t>(search_.triangles().size());
    std::vector<std::vector<std::uint32_t>> neighbours(positions_.size() - first);
    for (const Triangle& t : sheet_.triangles)
      for (std::size_t k = 0; k < 3; ++k)
        if (t[k] >= first) {
          neighbours[t[k] - first].push_back(t[(k + 1) % 3]);
          neighbours[t[k] - first].push_back(t[(k + 2) % 3]);
        }
    std::vector<Vector3d> move(neighbours.size(), Vector3d::Zero());
    std::vector<int> moves(neighbours.size(), 0);
    const auto add = [&](std::uint32_t v, const Vector3d& way) { move[v - first] += way, ++moves[v - first]; };
    for (const auto& [s, w] : pairs) {
      if (s >= old_count) {  // both triangles are of the sheet: to the mean of the neighbours
        for (const std::uint32_t t : {s, w})
          for (const std::uint32_t v : sheet_.triangles[t - old_count]) {
            if (v < first) continue;
            Vector3d middle = Vector3d::Zero();
            for (const std::uint32_t u : neighbours[v - first]) middle += positions_[u] / static_cast<double>(neighbours[v - first].size());
            add(v, (middle - positions_[v]) / 2);
          }
        continue;
      }
      const Vector3d out = outOf_(s);
      for (const std::uint32_t v : sheet_.triangles[w - old_count]) {
        const double beyond = out.dot(positions_[v] - positions_[search_.triangles()[s][0]]) + kClear * sheet_.edge;
        if (v >= first && beyond > 0) add(v, -std::min(beyond, sheet_.edge) * out);
      }
    }
    for (std::size_t i = 0; i < move.size(); ++i)
      if (moves[i] > 0) positions_[first + i] += move[i] / moves[i];
  }

  /// Inserts a vertex in the middle of the longest inner edge of each triangle that crosses something.
  void halveCrossing(const Pairs& pairs) {
    std::map<Edge, int> uses;
    for (const Triangle& t : sheet_.triangles)
      for (std::size_t k = 0; k < 3; ++k) ++uses[std::minmax(t[k], t[(k + 1) % 3])];
    const auto old_count = static_cast<std::uint32_t>(search_.triangles().size());
    std::set<Edge> split;
    for (const auto& [s, w] : pairs)
      for (const std::uint32_t i : {s, w}) {
        if (i < old_count) continue;
        const Triangle& t = sheet_.triangles[i - old_count];
        double longest = 0;
        Edge at{0, 0};
        for (std::size_t k = 0; k < 3; ++k) {
          const Edge e = std::minmax(t[k], t[(k + 1) % 3]);
          const double length = (positions_[e.first] - positions_[e.second]).norm();
          if (uses[e] == 2 && length > longest) longest = length, at = e;
        }
        if (longest > 0) split.insert(at);
      }
    for (const Edge& edge : split) splitEdge(positions_, sheet_, edge);
  }

  std::vector<Vector3d>& positions_;
  MovableSheet& sheet_;
  const CrossingSearch& search_;
  const std::function<Vector3d(std::uint32_t)>& outOf_;
};

}  // namespace

std::size_t moveApart(std::vector<Vector3d>& positions, MovableSheet& sheet, const CrossingSearch& search,
                      const std::function<Vector3d(std::uint32_t)>& outOf) {
  return Moving(positions, sheet, search, outOf).run();
}

void splitEdges(std::vector<Vector3d>& positions, MovableSheet& sheet, const std::function<bool(std::uint32_t, std::uint32_t)>& isBad) {
  std::set<Edge> bad;
  for (const Triangle& t : sheet.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      if (isBad(t[k], t[(k + 1) % 3])) bad.insert(std::minmax(t[k], t[(k + 1) % 3]));
  for (const Edge& edge : bad) splitEdge(positions, sheet, edge);
}

}  // namespace spheretree::builder
