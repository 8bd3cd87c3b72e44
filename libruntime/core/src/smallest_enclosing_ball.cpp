// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/smallest_enclosing_ball.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "spheretree/core/rounding.h"

namespace spheretree {
namespace {

/// Balls and points, which are balls of radius 0, share one search.
Ball ballOf(const Ball& ball) { return ball; }
Ball ballOf(const Eigen::Vector3d& point) { return {point, 0}; }

/// The radius about `centre` that encloses `ball`. The writer and the reader evaluate the same expression, and each of
/// its operations is correctly rounded everywhere, so that both get the same result.
double reach(const Eigen::Vector3d& centre, const Ball& ball) {
  const double dx = ball.centre.x() - centre.x(), dy = ball.centre.y() - centre.y(), dz = ball.centre.z() - centre.z();
  return std::sqrt(dx * dx + dy * dy + dz * dz) + ball.radius;
}

constexpr double kFlat =
    1e-15;  // squared area or volume of edges, divided by the product of their squares: below it, the edges count as dependent

constexpr std::size_t kMaxBasis = 4;  // balls that determine the smallest one around them, at most

/// Up to kMaxBasis balls, and one that enters.
struct Basis {
  std::array<Ball, kMaxBasis + 1> ball;
  std::array<std::size_t, kMaxBasis + 1> index;  // among all balls
  std::size_t size = 0;
  void add(const Ball& b, std::size_t i) { ball[size] = b, index[size++] = i; }
  bool contains(std::size_t i) const { return std::find(index.begin(), index.begin() + size, i) != index.begin() + size; }
};

/// Centres of the balls that enclose and touch the `chosen` balls (1 to 4), in the order of their radii: up to two.
/// With q_i = c_i - c_0 and d_i = r_i - r_0, a centre c_0 + x at s = R - r_0 satisfies |x| = s and 2 q_i . x = |q_i|^2
/// - d_i^2 + 2 d_i s: x is linear in s, and s solves a quadratic equation.
int tangentCentres(const Basis& balls, std::span<const std::size_t> chosen, std::array<Eigen::Vector3d, 2>& centres) {
  const Ball& origin = balls.ball[chosen[0]];
  if (chosen.size() == 1) {
    centres[0] = origin.centre;
    return 1;
  }
  const std::size_t count = chosen.size() - 1;
  std::array<Eigen::Vector3d, 3> q;
  std::array<double, 3> constant, slope;  // of the right-hand side in s
  for (std::size_t i = 0; i < count; ++i) {
    const Ball& ball = balls.ball[chosen[i + 1]];
    q[i] = ball.centre - origin.centre;
    slope[i] = ball.radius - origin.radius;
    constant[i] = 0.5 * (q[i].squaredNorm() - slope[i] * slope[i]);
  }
  // With the dual basis in the span of q, for which p_i . q_i = 1 and p_i . q_k = 0, x is the sum of p_i times the
  // right-hand sides.
  std::array<Eigen::Vector3d, 3> dual;
  double square = q[0].squaredNorm(), smallest = 0;
  if (count == 1) {
    dual[0] = q[0];
  } else if (count == 2) {
    const Eigen::Vector3d normal = q[0].cross(q[1]);
    dual = {q[1].cross(normal), normal.cross(q[0])};
    smallest = kFlat * square * q[1].squaredNorm();
    square = normal.squaredNorm();
  } else {
    dual = {q[1].cross(q[2]), q[2].cross(q[0]), q[0].cross(q[1])};
    const double volume = dual[0].dot(q[0]);
    smallest = kFlat * square * q[1].squaredNorm() * q[2].squaredNorm();
    square = volume * volume;
    for (Eigen::Vector3d& p : dual) p *= volume;
  }
  if (!(square > smallest)) return 0;
  Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = a;  // x = a + b s
  for (std::size_t i = 0; i < count; ++i) {
    a += dual[i] * (constant[i] / square);
    b += dual[i] * (slope[i] / square);
  }
  if (b.isZero(0)) {  // equal radii, as of points: the centre does not depend on s
    centres[0] = origin.centre + a;
    return centres[0].allFinite() ? 1 : 0;
  }
  const double qa = b.squaredNorm() - 1, qb = a.dot(b), qc = a.squaredNorm();  // qa s^2 + 2 qb s + qc = 0
  std::array<double, 2> roots{};
  int root_count = 0;
  if (std::abs(qa) < 1e-14) {
    if (qb != 0) roots[static_cast<std::size_t>(root_count++)] = -qc / (2 * qb);
  } else if (const double discriminant = qb * qb - qa * qc; discriminant >= 0) {
    const double sum = -(qb + std::copysign(std::sqrt(discriminant), qb));
    roots[static_cast<std::size_t>(root_count++)] = sum / qa;
    if (sum != 0) roots[static_cast<std::size_t>(root_count++)] = qc / sum;
  }
  int found = 0;
  for (int i = 0; i < root_count; ++i) {
    const Eigen::Vector3d centre = origin.centre + a + b * roots[static_cast<std::size_t>(i)];
    if (centre.allFinite()) centres[static_cast<std::size_t>(found++)] = centre;
  }
  return found;
}

double reachAll(const Eigen::Vector3d& centre, const Basis& basis) {
  double radius = 0;
  for (std::size_t i = 0; i < basis.size; ++i) radius = std::max(radius, reach(centre, basis.ball[i]));
  return radius;
}

/// The smallest ball that encloses the balls of `five` is determined by the first of them and at most three others, all
/// of which are tried. Returns its radius, which is infinite if none is found, and keeps those balls.
double keepBasis(Basis& five, Eigen::Vector3d& centre) {
  unsigned best = 0;
  double smallest = std::numeric_limits<double>::infinity();
  for (unsigned subset = 1; subset < (1u << five.size); subset += 2) {
    std::array<std::size_t, kMaxBasis + 1> chosen{};
    std::size_t count = 0;
    for (std::size_t i = 0; i < five.size; ++i)
      if (subset >> i & 1) chosen[count++] = i;
    if (count > kMaxBasis) continue;
    std::array<Eigen::Vector3d, 2> centres;
    const int found = tangentCentres(five, {chosen.data(), count}, centres);
    for (int i = 0; i < found; ++i) {
      const Eigen::Vector3d& c = centres[static_cast<std::size_t>(i)];
      if (reach(c, five.ball[0]) >= smallest) continue;  // so is that of all five
      const double radius = reachAll(c, five);
      if (radius < smallest) smallest = radius, centre = c, best = subset;
    }
  }
  Basis kept;
  for (std::size_t i = 0; i < five.size; ++i)
    if (best >> i & 1) kept.add(five.ball[i], five.index[i]);
  five = kept;
  return smallest;
}

/// The ball with the largest reach from `centre`, and that reach; the number of balls if none has one above 0.
struct Farthest {
  std::size_t index;
  double reach;
};
Farthest farthestOf(std::span<const Ball> balls, const Eigen::Vector3d& centre) {
  Farthest farthest{balls.size(), 0};
  for (std::size_t i = 0; i < balls.size(); ++i)
    if (const double r = reach(centre, balls[i]); r > farthest.reach) farthest = {i, r};
  return farthest;
}
Farthest farthestOf(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& centre) {
  Farthest farthest{points.size(), 0};
  for (std::size_t i = 0; i < points.size(); ++i)
    if (const double r2 = (points[i] - centre).squaredNorm(); r2 > farthest.reach) farthest = {i, r2};
  farthest.reach = std::sqrt(farthest.reach);
  return farthest;
}

/// Centre of the smallest ball that encloses all. A basis of at most four balls determines it. As long as some ball
/// protrudes, the farthest one enters, and the best basis among the five is found by trying all. Rounding can only make
/// the result slightly too large, since the caller measures the radius about the resulting centre.
template <class Item>
Eigen::Vector3d enclosingCentre(std::span<const Item> items) {
  std::size_t largest = 0;
  for (std::size_t i = 1; i < items.size(); ++i)
    if (ballOf(items[i]).radius > ballOf(items[largest]).radius) largest = i;
  Basis basis;
  basis.add(ballOf(items[largest]), largest);
  Eigen::Vector3d centre = basis.ball[0].centre, best_centre = centre;
  double basis_radius = basis.ball[0].radius, best_radius = std::numeric_limits<double>::infinity();
  for (;;) {  // about 10 times; the radius grows each time, so that no basis returns
    const auto [farthest, radius] = farthestOf(items, centre);
    if (radius < best_radius) best_radius = radius, best_centre = centre;
    if (farthest == items.size() || radius <= basis_radius * (1 + kRounding) || basis.contains(farthest)) break;

    Basis next;
    next.add(ballOf(items[farthest]), farthest);  // must be part of the new basis
    for (std::size_t i = 0; i < basis.size; ++i) next.add(basis.ball[i], basis.index[i]);
    const double next_radius = keepBasis(next, centre);
    if (!(next_radius > basis_radius)) break;
    basis_radius = next_radius;
    basis = next;
  }
  return best_centre;
}

template <class Item>
Ball enclosing(std::span<const Item> items) {
  if (items.empty()) return {};
  const Eigen::Vector3d centre = enclosingCentre(items);
  return {centre, farthestOf(items, centre).reach};
}

}  // namespace

Sphere smallestEnclosing(std::span<const Sphere> spheres) {
  std::vector<Ball> balls;
  for (const Sphere& s : spheres) balls.push_back({centreOf(s), s.radius});
  const Eigen::Vector3f centre = roundToFloat(enclosingCentre(std::span<const Ball>(balls)));
  const double radius = farthestOf(std::span<const Ball>(balls), centre.cast<double>()).reach;
  return {centre.x(), centre.y(), centre.z(), roundUp(radius)};
}

Ball smallestEnclosing(std::span<const Ball> balls) { return enclosing(balls); }

Ball smallestEnclosing(std::span<const Eigen::Vector3d> points) { return enclosing(points); }

}  // namespace spheretree
