// SPDX-License-Identifier: GPL-3.0-or-later
#include "medial/voronoi_balls.h"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "geometry/circumcentre.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Delaunay = CGAL::Delaunay_triangulation_3<Kernel>;

Vector3d toEigen(const Kernel::Point_3& p) { return {p.x(), p.y(), p.z()}; }

}  // namespace

std::vector<Ball> voronoiBalls(std::span<const Vector3d> points, const DistanceField& field) {
  std::vector<Kernel::Point_3> input;
  input.reserve(points.size());
  for (const Vector3d& p : points) input.emplace_back(p.x(), p.y(), p.z());
  const Delaunay delaunay(input.begin(), input.end());
  std::vector<Vector3d> centres;
  if (delaunay.dimension() == 3) {
    for (auto cell = delaunay.finite_cells_begin(); cell != delaunay.finite_cells_end(); ++cell) {
      const Vector3d c = circumcentre(toEigen(cell->vertex(0)->point()), toEigen(cell->vertex(1)->point()),
                                      toEigen(cell->vertex(2)->point()), toEigen(cell->vertex(3)->point()));
      if (c.allFinite() && field.box().contains(c)) centres.push_back(c);
    }
  }
  std::vector<Ball> balls(centres.size());
  tbb::parallel_for(std::size_t{0}, centres.size(), [&](std::size_t i) { balls[i] = {centres[i], -field.signedDistance(centres[i])}; });
  // Cospherical samples give the same centre many times, up to rounding: keeps the first centre in each grid cell.
  const double cell_size = 1e-8 * field.diagonal();
  struct Key {
    std::array<std::int64_t, 3> cell;
    std::size_t index;
    auto operator<=>(const Key&) const = default;
  };
  std::vector<Key> keys;
  keys.reserve(balls.size());
  for (std::size_t i = 0; i < balls.size(); ++i) {
    if (!(balls[i].radius > cell_size)) continue;
    const Vector3d q = (balls[i].centre - field.box().min()) / cell_size;
    keys.push_back({{std::llround(q.x()), std::llround(q.y()), std::llround(q.z())}, i});
  }
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end(), [](const Key& a, const Key& b) { return a.cell == b.cell; }), keys.end());
  std::sort(keys.begin(), keys.end(), [](const Key& a, const Key& b) { return a.index < b.index; });
  std::vector<Ball> kept;
  kept.reserve(keys.size());
  for (const Key& key : keys) kept.push_back(balls[key.index]);
  return kept;
}

}  // namespace spheretree::builder
