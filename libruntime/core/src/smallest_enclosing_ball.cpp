// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/smallest_enclosing_ball.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "spheretree/core/rounding.h"

namespace spheretree {
namespace {

struct Ball {
  Eigen::Vector3d centre;
  double radius;
};

/// The radius about `centre` that encloses `ball`. The writer and the reader evaluate the same expression, and each of
/// its operations is correctly rounded everywhere, so that both get the same result.
double reach(const Eigen::Vector3d& centre, const Ball& ball) {
  const double dx = ball.centre.x() - centre.x(), dy = ball.centre.y() - centre.y(), dz = ball.centre.z() - centre.z();
  return std::sqrt(dx * dx + dy * dy + dz * dz) + ball.radius;
}

constexpr double kFlat =
    1e-15;  // squared area or volume of edges, divided by the product of their squares: below it, the edges count as dependent

/// Centres of the balls that enclose and touch all of `support` (1 to 4 balls), in the order of their radii: up to two.
/// With q_i = c_i - c_0 and d_i = r_i - r_0, a centre c_0 + x at s = R - r_0 satisfies |x| = s and 2 q_i . x = |q_i|^2
/// - d_i^2 + 2 d_i s: x is linear in s, and s solves a quadratic equation.
int tangentCentres(std::span<const Ball* const> support, std::array<Eigen::Vector3d, 2>& centres) {
  const Ball& origin = *support[0];
  if (support.size() == 1) {
    centres[0] = origin.centre;
    return 1;
  }
  const std::size_t count = support.size() - 1;
  std::array<Eigen::Vector3d, 3> q;
  std::array<double, 3> constant, slope;  // of the right-hand side in s
  for (std::size_t i = 0; i < count; ++i) {
    const Ball& ball = *support[i + 1];
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

double reachAll(const Eigen::Vector3d& centre, std::span<const Ball* const> balls) {
  double radius = 0;
  for (const Ball* ball : balls) radius = std::max(radius, reach(centre, *ball));
  return radius;
}

/// Centre of the smallest ball that encloses `balls`. A basis of at most four balls determines it. As long as some ball
/// protrudes, the farthest one enters, and the best basis among the five is found by trying all. Rounding can only make
/// the result slightly too large, since the caller measures the radius about the resulting centre.
Eigen::Vector3d enclosingCentre(std::span<const Ball> balls) {
  std::vector<const Ball*> basis{&balls[0]};
  for (const Ball& ball : balls)
    if (ball.radius > basis[0]->radius) basis[0] = &ball;
  Eigen::Vector3d centre = basis[0]->centre, best_centre = centre;
  double basis_radius = basis[0]->radius, best_radius = std::numeric_limits<double>::infinity();
  constexpr int kMaxExchanges = 1000;  // about 10 are usual; the radius grows with each exchange, so that only rounding can cause a cycle
  for (int exchange = 0; exchange < kMaxExchanges; ++exchange) {
    const Ball* farthest = nullptr;
    double radius = 0;
    for (const Ball& ball : balls)
      if (const double r = reach(centre, ball); r > radius) radius = r, farthest = &ball;
    if (radius < best_radius) best_radius = radius, best_centre = centre;
    if (farthest == nullptr || radius <= basis_radius * (1 + 1e-12) || std::find(basis.begin(), basis.end(), farthest) != basis.end())
      break;

    basis.insert(basis.begin(), farthest);  // must be part of the new basis
    std::vector<const Ball*> next;
    double next_radius = std::numeric_limits<double>::infinity();
    for (unsigned subset = 1; subset < (1u << basis.size()); subset += 2) {
      if (std::popcount(subset) > 4) continue;
      std::vector<const Ball*> support;
      for (std::size_t i = 0; i < basis.size(); ++i)
        if (subset >> i & 1) support.push_back(basis[i]);
      std::array<Eigen::Vector3d, 2> centres;
      const int count = tangentCentres(support, centres);
      for (int i = 0; i < count; ++i) {
        const double r = reachAll(centres[static_cast<std::size_t>(i)], basis);
        if (r < next_radius) next_radius = r, centre = centres[static_cast<std::size_t>(i)], next = support;
      }
    }
    if (!(next_radius > basis_radius)) break;
    basis_radius = next_radius;
    basis = std::move(next);
  }
  return best_centre;
}

struct Enclosure {
  Eigen::Vector3f centre;  // rounded as in the file
  double radius;           // about the rounded centre
};

Enclosure enclose(std::span<const Ball> balls) {
  Enclosure out{enclosingCentre(balls).cast<float>(), 0};
  const Eigen::Vector3d centre = out.centre.cast<double>();
  for (const Ball& ball : balls) out.radius = std::max(out.radius, reach(centre, ball));
  return out;
}

}  // namespace

Sphere smallestEnclosing(std::span<const Sphere> spheres) {
  std::vector<Ball> balls;
  for (const Sphere& s : spheres) balls.push_back({centreOf(s), s.radius});
  const Enclosure e = enclose(balls);
  return {e.centre.x(), e.centre.y(), e.centre.z(), roundUp(e.radius)};
}

}  // namespace spheretree
