// SPDX-License-Identifier: GPL-3.0-or-later
// The walls in a surface, and how a further one is chosen such that it crosses nothing. Units: mm.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "split/crossing_search.h"
#include "split/scan_surface.h"

namespace spheretree::builder {

/// Triangles within the surface. They are wound outward for the region `above`; the region `below` uses them with the
/// opposite winding.
struct InnerWall {
  std::int32_t above = 0, below = 0;
  std::vector<Triangle> triangles = {};
};

class WallSet {
 public:
  /// `surface` must outlive this object. The vertices of the walls are appended to its mesh.
  explicit WallSet(ScanSurface& surface);

  void add(InnerWall wall) { walls_.push_back(std::move(wall)); }
  /// The triangles of the walls from `first` on.
  std::vector<Triangle> trianglesFrom(std::size_t first) const;
  /// Pairs of crossing triangles, as CrossingSearch gives them; the first triangles of the search are those of the
  /// surface. Walls that were added since the last addBest() are not searched.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> against(const std::vector<Triangle>& fresh) const { return search_.against(fresh); }

  /// Calls `attempt(i)`, which adds walls and vertices, for i = 0, 1, ... below `count` until nothing crosses. If all
  /// attempts have crossings, refines and moves their walls, in the order of increasing crossings, until one has none;
  /// otherwise keeps the best, and lists the triangles of the surface that it crosses. Returns the number of remaining
  /// crossings. `region`: the region that the walls close. `edge`: mean edge of their border [mm].
  std::size_t addBest(std::int32_t region, std::size_t count, double edge, const std::function<void(std::size_t)>& attempt);

  /// What undoTo() restores: it removes all later walls, with their vertices and crossings. Walls that were already
  /// there in an addBest() must stay.
  struct Mark {
    std::size_t points, walls, crossed;
  };
  Mark mark() const { return {surface_.mesh.positions.size(), walls_.size(), crossed_.size()}; }
  void undoTo(const Mark& mark);

  /// Hands over the walls; the set is empty afterwards.
  std::vector<InnerWall> takeWalls() { return std::move(walls_); }
  /// Triangles of the surface that a wall crosses, because no attempt avoided them; ascending.
  std::vector<std::uint32_t> crossedTriangles() const;

 private:
  void addToSearch();
  std::size_t moveApartFrom(const Mark& begin, std::int32_t region, double edge);
  Eigen::Vector3d outOf(std::int32_t region, std::uint32_t triangle) const;

  ScanSurface& surface_;
  std::vector<InnerWall> walls_;
  std::vector<std::uint32_t> crossed_;
  CrossingSearch search_;              // contains the surface, then the walls before the current attempt
  std::vector<std::int32_t> wall_of_;  // of each triangle in search_; -1: of the surface
  std::size_t walls_in_search_ = 0;
};

}  // namespace spheretree::builder
