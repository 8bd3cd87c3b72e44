// SPDX-License-Identifier: GPL-3.0-or-later
#include "cover/relax_cover.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "base/sum_in_order.h"
#include "geometry/ball_index.h"
#include "medial/refit_ball.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kGain = 0.01;  // share of the stand-off that a round has to gain, and that makes a change of the surface matter

struct Fit {
  Vector3d centre;
  double clearance;
  double stand_off;  // for its points
};

// For each ball, the points that it reaches with the smallest stand-off; ties go to the lower ball. `guess`: of the
// largest stand-off; it only saves time.
std::vector<std::vector<Vector3d>> patchesOf(const std::vector<Fit>& fits, std::span<const Vector3d> points, double guess) {
  std::vector<Ball> balls;
  for (const Fit& fit : fits) balls.push_back({fit.centre, fit.clearance});
  const BallIndex index(balls, guess);
  std::vector<std::uint32_t> owner(points.size());
  forEachIndex(points.size(), [&](std::size_t i) {
    std::pair<double, std::uint32_t> best{kInfinity, kNone};
    const auto offer = [&](std::uint32_t b) { best = std::min(best, {(points[i] - fits[b].centre).norm() - fits[b].clearance, b}); };
    index.tree.searchWithin(points[i], 0, [&](std::size_t first, std::size_t count) {
      for (std::size_t slot = first; slot < first + count; ++slot) offer(index.original(static_cast<std::uint32_t>(slot)));
    });
    if (best.first > guess)
      for (std::uint32_t b = 0; b < fits.size(); ++b) offer(b);
    owner[i] = best.second;
  });
  std::vector<std::vector<Vector3d>> patches(fits.size());
  for (std::size_t i = 0; i < points.size(); ++i) patches[owner[i]].push_back(points[i]);
  return patches;
}

double largestStandOff(const std::vector<Fit>& fits) {
  double largest = 0;
  for (const Fit& fit : fits) largest = std::max(largest, fit.stand_off);
  return largest;
}

}  // namespace

void relaxCover(const DistanceField& field, std::span<const Vector3d> points, double moved, std::vector<Ball>& balls, Progress& progress) {
  std::vector<Fit> fits(balls.size());
  forEachIndex(balls.size(), [&](std::size_t b) {
    const double clearance = -field.signedDistance(balls[b].centre);
    fits[b] = {balls[b].centre, clearance, balls[b].radius - clearance};
  });
  double guess = largestStandOff(fits), before = kInfinity, now = guess;
  if (balls.empty() || !(moved > kGain * guess)) return;
  while (now < (1 - kGain) * before) {
    progress.check();
    before = now;
    const std::vector<std::vector<Vector3d>> patches = patchesOf(fits, points, guess);
    forEachIndex(fits.size(), [&](std::size_t b) {
      const double width = std::sqrt(guess * (2 * std::max(fits[b].clearance, 0.0) + guess));
      const Refit refit = refitBall(field, patches[b], fits[b].centre, fits[b].clearance, kFirstStepShare * width, kCoverRefitSteps);
      fits[b] = {refit.centre, refit.clearance, refit.stand_off};
    });
    guess = now = largestStandOff(fits);
  }
  for (std::size_t b = 0; b < balls.size(); ++b) balls[b] = {fits[b].centre, fits[b].clearance + now};
}

}  // namespace spheretree::builder
