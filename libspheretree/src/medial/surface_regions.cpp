// SPDX-License-Identifier: GPL-3.0-or-later
#include "medial/surface_regions.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "geometry/ball_index.h"
#include "medial/refit_ball.h"
#include "medial/shrinking_balls.h"
#include "spheretree/core/rounding.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr int kRefitSteps = 16;
constexpr int kBalanceRounds = 40;
constexpr double kOnSurface = 1e-2;    // share of its reach: a ball of less clearance is replaced by one inside
constexpr double kBalanceStep = 0.2;   // of the first round that balances regions, as a share of the mean squared radius ...
constexpr double kBalanceDecay = 0.1;  // ... and how it falls with the rounds

// Enlarged a little, so that a point on a ball's surface counts as inside, whatever the rounding.
BallIndex indexOf(std::span<const FittedBall> balls) {
  std::vector<Ball> larger;
  larger.reserve(balls.size());
  for (const FittedBall& b : balls) larger.push_back({b.centre, b.radius * (1 + kRounding)});
  return BallIndex(larger);
}

// Calls visit(ball, distance of the point from its centre).
template <class Visit>
void forHolders(const BallIndex& index, const Vector3d& p, Visit&& visit) {
  index.tree.searchWithin(p, 0, [&](std::size_t first, std::size_t count) {
    for (auto slot = static_cast<std::uint32_t>(first); slot < first + count; ++slot) {
      const double distance = (p - index.balls[slot].centre).norm();
      if (distance <= index.balls[slot].radius) visit(index.original(slot), distance);
    }
  });
}

// A ball cannot be refitted if its centre is outside, or on the surface as for the smallest ball of a flat patch. It is
// replaced by the inner ball that touches the surface at the point nearest to the centre, unless that has a larger
// overhang.
void moveInside(const DistanceField& field, std::span<const Vector3d> patch, FittedBall& ball) {
  const double reach = farthest(patch, ball.centre);
  if (ball.clearance > kOnSurface * reach) return;
  const Ball inner = touchingBall(field, ball.centre);
  if (inner.radius > 0 && farthest(patch, inner.centre) - inner.radius < reach - ball.clearance) ball = {inner.centre, 0, inner.radius};
}

}  // namespace

std::vector<std::uint32_t> assignDeepest(std::span<const Vector3d> points, std::vector<FittedBall>& balls) {
  std::vector<std::uint32_t> owner(points.size(), kNone);
  const BallIndex index = indexOf(balls);
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    double smallest = kInfinity;
    forHolders(index, points[i], [&](std::uint32_t b, double distance) {
      const double gap = distance - balls[b].clearance;
      if (gap < smallest || (gap == smallest && b < owner[i])) smallest = gap, owner[i] = b;
    });
  });
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (owner[i] != kNone) continue;
    double smallest = kInfinity;
    for (std::uint32_t b = 0; b < balls.size(); ++b) {
      const double growth = (points[i] - balls[b].centre).norm() - balls[b].radius;
      if (growth < smallest) smallest = growth, owner[i] = b;
    }
    FittedBall& ball = balls[owner[i]];
    ball.radius = std::max(ball.radius, (points[i] - ball.centre).norm() * (1 + kRounding));
  }
  return owner;
}

void refitToPatch(const DistanceField& field, std::span<const Vector3d> patch, FittedBall& ball, double target) {
  if (!patch.empty()) moveInside(field, patch, ball);
  if (ball.clearance > 0 && patch.size() > 1) {
    const double overhang = std::max(0.0, ball.overhang());
    const double width = std::sqrt(overhang * (2 * ball.clearance + overhang));
    const Refit refit = refitBall(field, patch, ball.centre, ball.clearance, kFirstStepShare * width, kRefitSteps, target);
    ball.centre = refit.centre;
    ball.clearance = refit.clearance;
  }
  ball.radius = farthest(patch, ball.centre) * (1 + kRounding);
}

std::vector<Vector3d> farthestFirst(std::span<const Vector3d> all, std::size_t max_count) {
  if (all.size() <= max_count) return {all.begin(), all.end()};
  std::vector<double> distance2(all.size(), kInfinity);
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : all) mean += p / static_cast<double>(all.size());
  std::size_t next = 0;
  for (std::size_t i = 1; i < all.size(); ++i)
    if ((all[i] - mean).squaredNorm() > (all[next] - mean).squaredNorm()) next = i;
  std::vector<Vector3d> sparse;
  for (std::size_t k = 0; k < max_count; ++k) {
    const Vector3d p = all[next];
    sparse.push_back(p);
    next = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      distance2[i] = std::min(distance2[i], (all[i] - p).squaredNorm());
      if (distance2[i] > distance2[next]) next = i;
    }
  }
  return sparse;
}

std::vector<std::uint32_t> refitBalls(const DistanceField& field, std::span<const Vector3d> points, std::vector<FittedBall>& balls,
                                      int rounds, const Progress& progress) {
  std::vector<std::uint32_t> owner;
  for (int round = 0; round <= rounds; ++round) {
    progress.check();
    owner = assignDeepest(points, balls);
    std::vector<std::vector<Vector3d>> patch(balls.size());
    for (std::size_t i = 0; i < points.size(); ++i) patch[owner[i]].push_back(points[i]);
    tbb::parallel_for(std::size_t{0}, balls.size(), [&](std::size_t b) {
      if (round < rounds)
        refitToPatch(field, patch[b], balls[b]);
      else
        balls[b].radius = farthest(patch[b], balls[b].centre) * (1 + kRounding);
    });
  }
  return owner;
}

Holders findHolders(std::span<const Vector3d> points, std::span<const FittedBall> balls) {
  const BallIndex index = indexOf(balls);
  std::vector<std::vector<std::uint32_t>> held(points.size());
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    forHolders(index, points[i], [&](std::uint32_t b, double) { held[i].push_back(b); });
    std::sort(held[i].begin(), held[i].end());
  });
  Holders out;
  out.begin.push_back(0);
  for (const std::vector<std::uint32_t>& of_point : held) {
    out.ball.insert(out.ball.end(), of_point.begin(), of_point.end());
    out.begin.push_back(out.ball.size());
  }
  return out;
}

std::vector<char> maybeRedundant(const Holders& holders, std::span<const FittedBall> balls, std::span<const std::uint32_t> group,
                                 std::span<const char> fixed, std::span<const char> absent) {
  const auto isAbsent = [&](std::uint32_t b) { return !absent.empty() && absent[b]; };
  const std::size_t points = holders.begin.size() - 1;
  std::vector<std::vector<std::uint32_t>> held(balls.size());
  std::vector<std::uint32_t> times(points, 0);
  for (std::uint32_t i = 0; i < points; ++i)
    for (const std::uint32_t b : holders.of(i))
      if (!isAbsent(b)) ++times[i], held[b].push_back(i);
  std::vector<std::uint32_t> order, left;
  for (std::uint32_t b = 0; b < balls.size(); ++b) {
    if (isAbsent(b)) continue;
    order.push_back(b);
    if (group[b] >= left.size()) left.resize(group[b] + 1, 0);
    ++left[group[b]];
  }
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return balls[a].overhang() > balls[b].overhang(); });
  std::vector<char> redundant(balls.size(), 0);
  for (const std::uint32_t b : order) {
    if ((!fixed.empty() && fixed[b]) || left[group[b]] < 2) continue;
    if (std::any_of(held[b].begin(), held[b].end(), [&](std::uint32_t i) { return times[i] < 2; })) continue;
    redundant[b] = 1;
    --left[group[b]];
    for (const std::uint32_t i : held[b]) --times[i];
  }
  return redundant;
}

std::vector<std::uint32_t> assignToRegions(std::span<const Vector3d> points, std::span<const FittedBall> balls) {
  const Holders holders = findHolders(points, balls);
  std::vector<std::uint32_t> owner(points.size(), kNone), shared;
  std::vector<double> fixed_count(balls.size(), 0);
  double scale = 0;
  for (const FittedBall& b : balls) scale += b.radius * b.radius;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const auto of = holders.of(i);
    if (of.size() == 1) owner[i] = of[0], ++fixed_count[of[0]];
    if (of.size() > 1) shared.push_back(i);
  }
  if (shared.empty()) return owner;
  scale /= static_cast<double>(balls.size());
  const double wanted = static_cast<double>(points.size()) / static_cast<double>(balls.size());
  std::vector<double> shift(balls.size(), 0);
  double best = kInfinity;
  std::vector<std::uint32_t> choice(shared.size());
  for (int round = 0; round < kBalanceRounds; ++round) {
    std::vector<double> count = fixed_count;
    for (std::size_t k = 0; k < shared.size(); ++k) {
      const Vector3d& p = points[shared[k]];
      double smallest = kInfinity;
      for (const std::uint32_t b : holders.of(shared[k])) {
        const double power = (p - balls[b].centre).squaredNorm() - balls[b].radius * balls[b].radius + shift[b];
        if (power < smallest) smallest = power, choice[k] = b;
      }
      ++count[choice[k]];
    }
    double imbalance = 0;
    for (const double c : count) imbalance += c * c;
    if (imbalance < best) {
      best = imbalance;
      for (std::size_t k = 0; k < shared.size(); ++k) owner[shared[k]] = choice[k];
    }
    const double step = kBalanceStep * scale / (1 + kBalanceDecay * round);
    for (std::size_t b = 0; b < balls.size(); ++b) shift[b] += step * std::clamp(count[b] / wanted - 1, -1.0, 1.0);
  }
  return owner;
}

}  // namespace spheretree::builder
