// SPDX-License-Identifier: GPL-3.0-or-later
#include "skin/loop_limit.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

constexpr int kSolverRounds =
    60;  // iterations of the solver; the error falls by a factor of 4 or more in each of the first ones, and is far below float after 30

/// Weight of the control vertex in the limit mask of a vertex with n neighbours, each of which has the weight 1.
double loopWeight(std::size_t n) {
  const double turn = 0.375 + 0.25 * std::cos(2 * std::numbers::pi / static_cast<double>(n));
  const double beta = (0.625 - turn * turn) / static_cast<double>(n);
  return 0.375 / beta;
}

/// Normal from a ring of points, counter-clockwise, by the tangent masks of Loop's surface.
template <class Ring>
Vector3d ringNormal(const Ring& ring) {
  Vector3d u = Vector3d::Zero(), v = Vector3d::Zero();
  const double step = 2 * std::numbers::pi / static_cast<double>(ring.size());
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const double angle = step * static_cast<double>(i);
    u += std::cos(angle) * ring[i], v += std::sin(angle) * ring[i];
  }
  const Vector3d n = u.cross(v);
  const double length = n.norm();
  return length > 0 ? Vector3d(n / length) : Vector3d::Zero();
}

}  // namespace

LoopLimit::LoopLimit(const std::vector<Vector3d>& positions, const Rings& rings, const std::vector<std::array<std::uint32_t, 2>>& creases)
    : at_(positions), rings_(rings), control_(positions) {
  solve(creases);
}

// Computes control vertices by Gauss-Seidel iteration such that the limit surface passes through the vertices of the
// mesh, with the mask of a vertex with a ring or of a crease. No control vertex moves from its vertex by more than
// half of the mean length of the edges in its mask, so that noise does not make the surface oscillate.
void LoopLimit::solve(const std::vector<std::array<std::uint32_t, 2>>& creases) {
  struct Row {
    std::uint32_t vertex;
    double weight, reach;
    std::vector<std::uint32_t> next;
  };
  std::vector<Row> rows;
  for (std::uint32_t v = 0; v < rings_.size(); ++v) {
    const auto& [p, q] = creases[v];
    Row row{v, 4, 0, {}};
    if (!rings_[v].empty())
      row.next = rings_[v], row.weight = loopWeight(rings_[v].size());
    else if (p != q)
      row.next = {p, q};
    else
      continue;
    for (const std::uint32_t w : row.next) row.reach += (at_[w] - at_[v]).norm() / (2 * static_cast<double>(row.next.size()));
    rows.push_back(std::move(row));
  }
  for (int round = 0; round < kSolverRounds; ++round) {
    for (const Row& row : rows) {
      const auto n = static_cast<double>(row.next.size());
      Vector3d sum = Vector3d::Zero();
      for (const std::uint32_t w : row.next) sum += control_[w];
      Vector3d moved = ((row.weight + n) * at_[row.vertex] - sum) / row.weight - at_[row.vertex];
      if (const double length = moved.norm(); length > row.reach) moved *= row.reach / length;
      control_[row.vertex] = at_[row.vertex] + moved;
    }
  }
}

Vector3d LoopLimit::normal(std::uint32_t v) const {
  std::vector<Vector3d> ring;
  for (const std::uint32_t w : rings_[v]) ring.push_back(control_[w]);
  return ringNormal(ring);
}

// After one step of subdivision the middle is a vertex with six neighbours: its position and normal are those of the
// limit there.
LoopLimit::Middle LoopLimit::middle(std::uint32_t a, std::uint32_t b) const {
  const std::vector<std::uint32_t>&ra = rings_[a], &rb = rings_[b];
  const auto placeOf = [](const std::vector<std::uint32_t>& ring, std::uint32_t v) {
    return static_cast<std::size_t>(std::find(ring.begin(), ring.end(), v) - ring.begin());
  };
  const std::size_t n = ra.size(), m = rb.size(), i = placeOf(ra, b), j = placeOf(rb, a);
  const auto p = [&](std::uint32_t v) -> const Vector3d& { return control_[v]; };
  const std::uint32_t left = ra[(i + 1) % n], right = ra[(i + n - 1) % n];
  const auto edgePoint = [&](std::uint32_t from, std::uint32_t to, std::uint32_t s, std::uint32_t t) {
    return Vector3d(0.375 * (p(from) + p(to)) + 0.125 * (p(s) + p(t)));
  };
  const std::array<Vector3d, 6> ring{subdivided(b), edgePoint(b, left, a, rb[(j + m - 2) % m]),  edgePoint(a, left, b, ra[(i + 2) % n]),
                                     subdivided(a), edgePoint(a, right, b, ra[(i + n - 2) % n]), edgePoint(b, right, a, rb[(j + 2) % m])};
  Vector3d sum = 6 * edgePoint(a, b, left, right);
  for (const Vector3d& q : ring) sum += q;
  return {sum / 12 - 0.5 * (at_[a] + at_[b]), ringNormal(ring)};
}

/// The position of a control vertex after one step of subdivision.
Vector3d LoopLimit::subdivided(std::uint32_t v) const {
  const auto n = static_cast<double>(rings_[v].size());
  const double beta = 0.375 / loopWeight(rings_[v].size());
  Vector3d sum = Vector3d::Zero();
  for (const std::uint32_t w : rings_[v]) sum += control_[w];
  return (1 - n * beta) * control_[v] + beta * sum;
}

}  // namespace spheretree::builder
