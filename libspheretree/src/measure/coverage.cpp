// SPDX-License-Identifier: GPL-3.0-or-later
#include "measure/coverage.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

/// In [0, 1); one step of SplitMix64 (G. Steele, D. Lea, C. Flood. Fast splittable pseudorandom number generators.
/// OOPSLA 2014).
double unitFrom(std::uint64_t state) {
  state += 0x9e3779b97f4a7c15u;
  state = (state ^ (state >> 30)) * 0xbf58476d1ce4e5b9u;
  state = (state ^ (state >> 27)) * 0x94d049bb133111ebu;
  return static_cast<double>((state ^ (state >> 31)) >> 11) * 0x1p-53;
}

/// A piece of a triangle of the mesh.
struct Piece {
  std::array<Vector3d, 3> corner;
};

struct Verdict {
  double bound = 0;  // upper bound of the gap over the piece [mm]
  double gap = 0;    // gap at the middle of the piece [mm]
  Vector3d middle = Vector3d::Zero();
};

Verdict judge(const SphereUnion& balls, const Piece& piece) {
  const auto& [a, b, c] = piece.corner;
  Verdict out;
  out.middle = (a + b + c) / 3;
  const SphereUnion::Nearest nearest = balls.nearest(out.middle);
  out.gap = nearest.gap;
  // The distance to one ball is convex, so that over the piece it is largest at a corner; and the gap is 1-Lipschitz.
  const Ball& ball = balls.balls()[nearest.ball];
  double far = 0, spread = 0;
  for (const Vector3d& p : piece.corner) {
    far = std::max(far, (p - ball.centre).norm());
    spread = std::max(spread, (p - out.middle).norm());
  }
  out.bound = std::min(far - ball.radius, nearest.gap + spread);
  return out;
}

/// Halves or quarters a piece, so that pieces become compact for any triangle.
void cut(const Piece& piece, std::vector<Piece>& out) {
  const auto& corner = piece.corner;
  std::array<double, 3> side2{};  // squared sides, opposite each corner
  for (std::size_t k = 0; k < 3; ++k) side2[k] = (corner[(k + 1) % 3] - corner[(k + 2) % 3]).squaredNorm();
  const auto longest = static_cast<std::size_t>(std::max_element(side2.begin(), side2.end()) - side2.begin());
  const Vector3d &tip = corner[longest], &left = corner[(longest + 1) % 3], &right = corner[(longest + 2) % 3];
  const Vector3d base = 0.5 * (left + right);
  if (side2[longest] > 6 * std::min({side2[0], side2[1], side2[2]})) {
    out.push_back({{tip, left, base}});
    out.push_back({{tip, base, right}});
    return;
  }
  const Vector3d to_left = 0.5 * (tip + left), to_right = 0.5 * (tip + right);
  out.push_back({{tip, to_left, to_right}});
  out.push_back({{to_left, left, base}});
  out.push_back({{to_right, base, right}});
  out.push_back({{to_left, base, to_right}});
}

/// Branch and bound over the triangles in rounds, so that the result does not depend on the threads.
void searchLargestGap(const TriangleMesh& mesh, const SphereUnion& balls, const CoverageSettings& settings, Progress& progress,
                      Coverage& out) {
  std::vector<Piece> pieces;
  pieces.reserve(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) pieces.push_back({{mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)}});
  std::size_t judged = 0;
  std::vector<Verdict> verdicts;
  std::vector<Piece> next;
  double coarse = 0;  // bound of the previous round
  while (!pieces.empty()) {
    judged += pieces.size();
    if (judged > std::max(settings.max_pieces, 2 * mesh.triangles.size())) {
      out.max_gap_bound = std::max(out.max_gap_bound, coarse);
      return;
    }
    verdicts.assign(pieces.size(), {});
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, pieces.size(), 256), [&](const tbb::blocked_range<std::size_t>& range) {
      if (progress.cancelled()) return;
      for (std::size_t i = range.begin(); i < range.end(); ++i) verdicts[i] = judge(balls, pieces[i]);
    });
    progress.check();
    for (const Verdict& verdict : verdicts)
      if (verdict.gap > std::max(out.max_gap, settings.tolerance)) out.max_gap = verdict.gap, out.worst_point = verdict.middle;
    const double target = std::max(out.max_gap, settings.tolerance) + 0.5 * settings.tolerance;
    next.clear();
    coarse = 0;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      if (verdicts[i].bound <= target) {
        out.max_gap_bound = std::max(out.max_gap_bound, verdicts[i].bound);
        continue;
      }
      coarse = std::max(coarse, verdicts[i].bound);
      cut(pieces[i], next);
    }
    pieces.swap(next);
  }
}

}  // namespace

std::vector<SurfacePoint> spreadOverSurface(const TriangleMesh& mesh, std::size_t count, std::uint64_t seed) {
  std::vector<double> area_up_to(mesh.triangles.size());
  double area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    area += 0.5 * (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
    area_up_to[t] = area;
  }
  std::vector<SurfacePoint> points;
  if (!(area > 0)) return points;
  points.reserve(count);
  // Steps that no small multiple brings close to an integer: powers of the root of x^3 = x + 1.
  constexpr double kStepU = 0.7548776662466927, kStepV = 0.5698402909980532;
  double u = unitFrom(seed), v = unitFrom(~seed);
  std::size_t t = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double at = area * ((static_cast<double>(i) + 0.5) / static_cast<double>(count));
    while (t + 1 < area_up_to.size() && area_up_to[t] <= at) ++t;
    u += kStepU, v += kStepV;
    u -= std::floor(u), v -= std::floor(v);
    const bool beyond = u + v > 1;  // folds the upper half of the square onto the lower half
    const double b = beyond ? 1 - u : u, c = beyond ? 1 - v : v;
    points.push_back({(1 - b - c) * mesh.corner(t, 0) + b * mesh.corner(t, 1) + c * mesh.corner(t, 2), static_cast<std::uint32_t>(t)});
  }
  return points;
}

Coverage measureCoverage(const TriangleMesh& mesh, const SphereUnion& balls, const CoverageSettings& settings, Progress& progress) {
  if (!(settings.tolerance > 0)) throw std::invalid_argument("coverage: the tolerance must be above 0");
  Coverage out;
  if (balls.size() == 0) {
    out.uncovered_fraction = 1;
    out.max_gap = out.max_gap_bound = std::numeric_limits<double>::infinity();
    return out;
  }
  const std::vector<SurfacePoint> samples = spreadOverSurface(mesh, settings.samples, settings.seed);
  const std::size_t count = samples.size();
  if (count == 0) throw std::invalid_argument("coverage: the mesh has no area");
  std::vector<char> open(count, 0);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 1024), [&](const tbb::blocked_range<std::size_t>& range) {
    if (progress.cancelled()) return;
    for (std::size_t i = range.begin(); i < range.end(); ++i) open[i] = !balls.covers(samples[i].point, settings.tolerance);
  });
  progress.check();
  out.uncovered_fraction = static_cast<double>(std::count(open.begin(), open.end(), 1)) / static_cast<double>(count);

  // Corners first, since they are most likely to be uncovered.
  for (const Vector3d& p : mesh.positions) {
    if (balls.covers(p, settings.tolerance)) continue;
    const double gap = balls.nearest(p).gap;
    if (gap > std::max(out.max_gap, settings.tolerance)) out.max_gap = gap, out.worst_point = p;
  }
  searchLargestGap(mesh, balls, settings, progress, out);
  out.max_gap_bound = std::max(out.max_gap_bound, out.max_gap);
  return out;
}

}  // namespace spheretree::builder
