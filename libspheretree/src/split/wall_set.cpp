// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/wall_set.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <utility>

#include "repair/fill_holes.h"
#include "split/move_apart.h"

namespace spheretree::builder {

using Eigen::Vector3d;

WallSet::WallSet(ScanSurface& surface)
    : surface_(surface), search_(surface.mesh.positions, meanEdge(surface)), wall_of_(surface.mesh.triangles.size(), -1) {
  for (const Triangle& t : surface.mesh.triangles) search_.add(t);
}

std::vector<Triangle> WallSet::trianglesFrom(std::size_t first) const {
  std::vector<Triangle> triangles;
  for (std::size_t w = first; w < walls_.size(); ++w)
    triangles.insert(triangles.end(), walls_[w].triangles.begin(), walls_[w].triangles.end());
  return triangles;
}

void WallSet::undoTo(const Mark& mark) {
  surface_.mesh.positions.resize(mark.points);
  walls_.resize(mark.walls);
  crossed_.resize(mark.crossed);
}

std::vector<std::uint32_t> WallSet::crossedTriangles() const {
  std::vector<std::uint32_t> crossed = crossed_;
  std::sort(crossed.begin(), crossed.end());
  crossed.erase(std::unique(crossed.begin(), crossed.end()), crossed.end());
  return crossed;
}

/// Adds the walls to the search that are not yet in it.
void WallSet::addToSearch() {
  for (; walls_in_search_ < walls_.size(); ++walls_in_search_)
    for (const Triangle& t : walls_[walls_in_search_].triangles) {
      search_.add(t);
      wall_of_.push_back(static_cast<std::int32_t>(walls_in_search_));
    }
}

std::size_t WallSet::addBest(std::int32_t region, std::size_t count, double edge, const std::function<void(std::size_t)>& attempt) {
  addToSearch();
  std::vector<Vector3d>& positions = surface_.mesh.positions;
  const Mark begin = mark();
  std::vector<std::pair<std::size_t, std::size_t>> order;  // crossings, attempt
  for (std::size_t i = 0; i < count; ++i) {
    attempt(i);
    const std::size_t crossings = search_.against(trianglesFrom(begin.walls)).size();
    if (crossings == 0) return 0;
    order.emplace_back(crossings, i);
    undoTo(begin);
  }
  std::sort(order.begin(), order.end());
  std::size_t fewest_crossings = std::numeric_limits<std::size_t>::max();
  std::vector<Vector3d> best_positions;
  std::vector<InnerWall> best_walls;
  for (const auto& [crossings, i] : order) {
    attempt(i);
    for (std::size_t w = begin.walls; w < walls_.size(); ++w) refineSpan(surface_.mesh, walls_[w].triangles, kSheetDensity);
    const std::size_t left = moveApartFrom(begin, region, edge);
    if (left == 0) return 0;
    if (left < fewest_crossings) {
      fewest_crossings = left;
      best_positions.assign(positions.begin() + static_cast<std::ptrdiff_t>(begin.points), positions.end());
      best_walls.assign(walls_.begin() + static_cast<std::ptrdiff_t>(begin.walls), walls_.end());
    }
    undoTo(begin);
  }
  positions.insert(positions.end(), best_positions.begin(), best_positions.end());
  walls_.insert(walls_.end(), best_walls.begin(), best_walls.end());
  for (const auto& [first, second] : search_.against(trianglesFrom(begin.walls)))
    if (first < wall_of_.size() && wall_of_[first] < 0) crossed_.push_back(first);
  return fewest_crossings;
}

/// Moves the vertices that came after `begin` until the walls after it cross nothing. Returns the number of remaining
/// pairs.
std::size_t WallSet::moveApartFrom(const Mark& begin, std::int32_t region, double edge) {
  MovableSheet sheet{.first_new = begin.points, .edge = edge};
  for (std::size_t w = begin.walls; w < walls_.size(); ++w)
    for (const Triangle& t : walls_[w].triangles) {
      sheet.triangles.push_back(t);
      sheet.group.push_back(static_cast<std::uint32_t>(w));
    }
  const std::size_t left =
      moveApart(surface_.mesh.positions, sheet, search_, [this, region](std::uint32_t triangle) { return outOf(region, triangle); });
  for (std::size_t w = begin.walls; w < walls_.size(); ++w) walls_[w].triangles.clear();
  for (std::size_t i = 0; i < sheet.triangles.size(); ++i) walls_[sheet.group[i]].triangles.push_back(sheet.triangles[i]);
  return left;
}

/// Unit normal of a triangle in the search, pointing away from the side where walls of `region` may be.
Vector3d WallSet::outOf(std::int32_t region, std::uint32_t triangle) const {
  const Triangle& t = search_.triangles()[triangle];
  const std::vector<Vector3d>& p = surface_.mesh.positions;
  const Vector3d n = (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).normalized();
  const std::int32_t wall = wall_of_[triangle];
  if (wall < 0) return n;
  return walls_[static_cast<std::size_t>(wall)].above == region ? n : Vector3d(-n);
}

}  // namespace spheretree::builder
