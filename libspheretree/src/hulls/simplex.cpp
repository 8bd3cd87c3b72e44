// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/simplex.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Regular_triangulation_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <tbb/parallel_for.h>

#include <utility>

#include "hulls/inscribed_ball.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Kernel, CGAL::Regular_triangulation_vertex_base_3<Kernel>>;
using Triangulation =
    CGAL::Regular_triangulation_3<Kernel,
                                  CGAL::Triangulation_data_structure_3<VertexBase, CGAL::Regular_triangulation_cell_base_3<Kernel>>>;

constexpr double kSteepest = 0.99;    // of a hull: well below kSteepestHull, so that rounding cannot reach that
constexpr std::size_t kEstimate = 8;  // steps along a side for the estimate of the overhang; a power of two

bool isThin(const Hull& hull) {
  if (hull.count < 3) return false;
  const Vector3d a = hull.ball[1].centre - hull.ball[0].centre, b = hull.ball[2].centre - hull.ball[0].centre;
  return a.cross(b).norm() < kThinnest * std::max({a.squaredNorm(), b.squaredNorm(), (b - a).squaredNorm()});
}

// The largest overhang of some balls of the hull; infinite once it exceeds the limit.
double estimatedOverhang(const DistanceField& field, const Hull& hull, double limit) {
  double largest = 0;
  const auto isWithin = [&](double w1, double w2) {
    const double w0 = 1 - w1 - w2;
    const auto& [a, b, c] = hull.ball;
    largest = std::max(largest,
                       w0 * a.radius + w1 * b.radius + w2 * c.radius + field.signedDistance(w0 * a.centre + w1 * b.centre + w2 * c.centre));
    return largest <= limit;
  };
  // The middles first, since the overhang is largest there for most hulls that reach out too far.
  for (std::size_t steps = 2; hull.count > 1 && steps <= kEstimate; steps *= 2)
    for (std::size_t i = 0; i <= steps; ++i)
      for (std::size_t j = 0; j <= (hull.count == 3 ? steps - i : 0); ++j) {
        if (i % 2 == 0 && j % 2 == 0) continue;  // done in the round before, or a corner
        const double share = 1 / static_cast<double>(steps);
        if (!isWithin(share * static_cast<double>(i), share * static_cast<double>(j))) return kInfinity;
      }
  return largest;
}

// Numbers of the balls of each triangle, side and corner of their regular triangulation.
std::vector<std::vector<std::uint32_t>> facesOf(std::span<const Ball> balls) {
  std::vector<std::pair<Kernel::Weighted_point_3, std::uint32_t>> points;
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::uint32_t i = 0; i < balls.size(); ++i) {
    const Ball& b = balls[i];
    points.push_back({{{b.centre.x(), b.centre.y(), b.centre.z()}, b.radius * b.radius}, i});
    faces.push_back({i});
  }
  const Triangulation triangulation(points.begin(), points.end());
  for (auto edge = triangulation.finite_edges_begin(); edge != triangulation.finite_edges_end(); ++edge)
    faces.push_back({edge->first->vertex(edge->second)->info(), edge->first->vertex(edge->third)->info()});
  for (auto facet = triangulation.finite_facets_begin(); facet != triangulation.finite_facets_end(); ++facet) {
    faces.emplace_back();
    for (int k = 0; k < 4; ++k)
      if (k != facet->second) faces.back().push_back(facet->first->vertex(k)->info());
  }
  return faces;
}

}  // namespace

std::vector<Simplex> simplicesOf(const DistanceField& field, std::vector<NumberedBall> corners, double limit) {
  std::ranges::sort(corners, {}, &NumberedBall::number);
  const std::size_t count = corners.size();
  Simplex s;
  s.hull.count = count;
  for (std::size_t k = 0; k < count; ++k) s.corner[k] = corners[k].number, s.hull.ball[k] = corners[k].ball;
  if (steepness(s.hull) < kSteepest && !isThin(s.hull)) {
    s.overhang = estimatedOverhang(field, s.hull, limit);
    s.distance.emplace(s.hull);
    if (s.overhang <= limit) return {s};
  }
  std::vector<Simplex> sides;
  for (std::size_t k = 0; count > 1 && k < count; ++k) {
    std::vector<NumberedBall> side = corners;
    side.erase(side.begin() + static_cast<std::ptrdiff_t>((k + count - 1) % count));
    for (Simplex& made : simplicesOf(field, std::move(side), limit)) sides.push_back(std::move(made));
  }
  return sides;
}

std::vector<Simplex> triangulated(const DistanceField& field, std::span<const Ball> balls, double limit) {
  const std::vector<std::vector<std::uint32_t>> faces = facesOf(balls);
  std::vector<std::vector<Simplex>> made(faces.size());
  tbb::parallel_for(std::size_t{0}, made.size(), [&](std::size_t i) {
    std::vector<NumberedBall> corners;
    for (const std::uint32_t v : faces[i]) corners.push_back({v, balls[v]});
    made[i] = simplicesOf(field, std::move(corners), limit);
  });
  // In an order that is the same in each run, unlike that of the triangulation; no hull before those that it is in.
  std::vector<Simplex> all, out;
  for (const auto& some : made) all.insert(all.end(), some.begin(), some.end());
  std::ranges::sort(all, {}, [](const Simplex& s) { return std::pair(3 - s.hull.count, s.corner); });
  std::vector<std::vector<std::uint32_t>> of(balls.size());  // (ball) those of `out` that have it
  for (Simplex& s : all) {
    if (std::ranges::any_of(of[s.corner[0]], [&](std::uint32_t i) { return s.isIn(out[i]); })) continue;
    for (const std::uint32_t v : s.corners()) of[v].push_back(static_cast<std::uint32_t>(out.size()));
    out.push_back(std::move(s));
  }
  return out;
}

}  // namespace spheretree::builder
