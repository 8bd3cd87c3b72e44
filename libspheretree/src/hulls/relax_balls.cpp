// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/relax_balls.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <span>
#include <vector>

#include "hulls/hull_change.h"
#include "hulls/inscribed_ball.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kNear = 8;       // balls that are moved at a time
constexpr int kSweeps = 2;             // over them, for each length of moves
constexpr double kLastRelaxed = 0.01;  // smallest of these lengths, as a share of the radius
constexpr double kGain = 0.999;        // of a move: of the energy before

// Along the line from the nearest neighbour to the one opposite to it, so that balls stay on a round border; towards
// the neighbour that is farthest from that line; and across both.
Eigen::Matrix3d axesOf(const HullComplex& complex, const Vector3d& c, std::span<const std::uint32_t> neighbours) {
  std::vector<Vector3d> to;
  for (const std::uint32_t v : neighbours) to.push_back(complex.balls()[v].centre - c);
  const Vector3d next = std::ranges::min_element(to, {}, [](const Vector3d& p) { return p.squaredNorm(); })->normalized();
  const Vector3d opposite = std::ranges::min_element(to, {}, [&](const Vector3d& p) { return p.normalized().dot(next); })->normalized();
  const Vector3d along = opposite.dot(next) < 0 ? (next - opposite).normalized() : next;
  const auto farOff = [&](const Vector3d& p) { return (p - p.dot(along) * along).squaredNorm(); };
  return axesFrom(along, *std::ranges::max_element(to, {}, farOff), 0);
}

// Moves ball `v` to where the hulls around it cost less. Its new number.
std::uint32_t moved(HullComplex& complex, std::uint32_t v, double step, double limit) {
  const Ball ball = complex.balls()[v];
  const std::vector<std::uint32_t> other = complex.neighbours(v);
  if (other.empty()) return v;
  const Eigen::Matrix3d axes = axesOf(complex, ball.centre, other);
  std::vector<Ball> places;
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      const Vector3d c = ball.centre + sign * step * ball.radius * axes.col(axis);
      places.push_back({c, -complex.task().field.signedDistance(c)});
    }
  places.push_back(ball);
  std::vector<HullChange> tried(places.size());
  tbb::parallel_for(std::size_t{0}, tried.size(), [&](std::size_t i) {
    if (places[i].radius > 0) tried[i] = moveOf(complex, v, places[i], limit);
  });
  const auto best = std::ranges::min_element(tried, {}, &HullChange::energy);
  if (!(best->energy < kGain * tried.back().energy)) return v;
  complex.apply(*best);
  return best->to;
}

// The balls nearest to ball `centre` of those that some steps from ball to ball reach.
std::vector<std::uint32_t> ringAround(const HullComplex& complex, std::uint32_t centre) {
  std::vector<std::uint32_t> ring{centre};
  for (std::size_t k = 0, rings = 0; rings < kNear / 2; ++rings)
    for (const std::size_t end = ring.size(); k < end; ++k)
      for (const std::uint32_t w : complex.neighbours(ring[k]))
        if (std::ranges::find(ring, w) == ring.end()) ring.push_back(w);
  const Vector3d middle = complex.balls()[centre].centre;
  std::ranges::stable_sort(ring, {}, [&](std::uint32_t v) { return (complex.balls()[v].centre - middle).squaredNorm(); });
  ring.resize(std::min(ring.size(), kNear));
  return ring;
}

double worstNear(const HullComplex& complex, std::span<const std::uint32_t> ring) {
  double worst = 0;
  for (const std::uint32_t v : ring)
    for (const std::uint32_t i : complex.around(v)) {
      const Simplex& s = complex.simplices()[i];
      worst = std::max(worst, s.overhang);
      for (const std::uint32_t p : s.samples) worst = std::max(worst, complex.samples()[p].cost);
    }
  return worst;
}

}  // namespace

void relaxBalls(HullComplex& complex, std::uint32_t centre, double limit) {
  std::vector<std::uint32_t> ring = ringAround(complex, centre);
  for (double step = kFirstMove; step > kLastRelaxed; step *= 0.5)
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      bool has_moved = false;
      for (std::uint32_t& v : ring) {
        const std::uint32_t w = moved(complex, v, step, limit);
        has_moved |= w != v;
        v = w;
      }
      if (worstNear(complex, ring) <= complex.most()) return;
      if (!has_moved) break;
    }
}

}  // namespace spheretree::builder
