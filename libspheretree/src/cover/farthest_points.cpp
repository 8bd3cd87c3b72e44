// SPDX-License-Identifier: GPL-3.0-or-later
#include "cover/farthest_points.h"

#include <cmath>
#include <queue>
#include <utility>

#include "geometry/sample_index.h"
#include "medial/shrinking_balls.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

// The largest ball that leaves the point of the surface `gap`; the one that touches it if there is none; else a point.
Ball ballNear(const DistanceField& field, const Vector3d& p, double gap) {
  const NearestPoint here = field.nearest(p);
  const Vector3d normal = field.pseudonormal(here);
  for (const double stand_off : {gap, 0.0})
    if (const Ball ball = shrinkingBall(field, here.point, normal, stand_off); ball.radius > 0) return ball;
  return {here.point, 0};
}

}  // namespace

std::vector<Ball> farthestPointBalls(const DistanceField& field, std::span<const Vector3d> given, std::size_t count) {
  const SampleIndex samples(given);
  std::vector<double> gap(samples.size(), field.diagonal());      // more than any, before the first ball
  std::priority_queue<std::pair<double, std::uint32_t>> largest;  // at least the gap of each sample
  for (std::uint32_t s = 0; s < samples.size(); ++s) largest.push({gap[s], s});
  std::vector<Ball> balls;
  while (balls.size() < count && !largest.empty()) {
    const auto [known, s] = largest.top();
    largest.pop();
    if (gap[s] == known) {
      const Ball ball = ballNear(field, samples[s], balls.empty() ? 0 : 0.5 * known);
      if (balls.empty() && !(ball.radius > 0)) continue;  // a sample on an edge, or there is no solid
      samples.within(ball.centre, ball.radius + known,
                     [&](std::uint32_t i, double distance) { gap[i] = std::min(gap[i], distance - ball.radius); });
      balls.push_back(ball);
      if (!(gap[s] < known)) continue;  // rounding: no ball comes nearer to it
    }
    if (gap[s] > 0) largest.push({gap[s], s});
  }
  return balls;
}

}  // namespace spheretree::builder
