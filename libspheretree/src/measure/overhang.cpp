// SPDX-License-Identifier: GPL-3.0-or-later
#include "measure/overhang.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kGrain = 64;         // items in a task of a parallel loop
constexpr std::size_t kFirstClimbs = 192;  // climbs from the highest samples
constexpr std::size_t kClimbsARound = 16;  // climbs in a round of the proof, from the middles of undecided patches ...
constexpr double kWorthAClimb = 0.97;      // ... whose overhang is at least this share of the highest one
constexpr std::uint32_t kNoTriangle = 0xffffffffu;

template <class Body>
void forEachIndex(std::size_t count, const Progress& progress, Body&& body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kGrain), [&](const tbb::blocked_range<std::size_t>& range) {
    if (progress.cancelled()) return;
    for (std::size_t i = range.begin(); i < range.end(); ++i) body(i);
  });
  progress.check();
}

/// A point of the boundary of the union.
struct Summit {
  std::uint32_t ball = 0;
  Vector3d direction = Vector3d::Zero();  // unit vector from the centre of `ball`
  double overhang = 0;                    // [mm]; <= 0: not outside the mesh
  double spacing = 0;                     // distance of the next trial points [rad]
};

/// Signed distances of points on the balls' surfaces. A point outside the mesh on ball (c, r) has a distance of at most
/// r + s(c), where s is the signed distance, so a search can be limited to that distance: a point without a triangle
/// within it is inside.
class Overhangs {
 public:
  Overhangs(const DistanceField& field, const SphereUnion& balls) : field_(field), balls_(balls), reach_(balls.size()) {
    const Eigen::AlignedBox3d box = field.box().merged(balls.box());
    rounding_ = 1e-12 * std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff());
    for (std::size_t i = 0; i < balls.size(); ++i)
      reach_[i] = balls.balls()[i].radius + field.signedDistance(balls.balls()[i].centre) + rounding_;
  }

  const DistanceField& field() const { return field_; }
  const SphereUnion& balls() const { return balls_; }
  double rounding() const { return rounding_; }            // upper bound of the error of any distance here [mm]
  double reach(std::size_t i) const { return reach_[i]; }  // upper bound of the overhang of ball i [mm]

  Vector3d point(std::size_t i, const Vector3d& u) const { return balls_.balls()[i].centre + balls_.balls()[i].radius * u; }

  /// Signed distance at direction `u` of ball `i`, which must be at most `max_distance`; if it is at most
  /// -max_distance, the result is any value of at most -max_distance.
  double at(std::size_t i, const Vector3d& u, double max_distance, NearestPoint* nearest = nullptr) const {
    const Vector3d p = point(i, u);
    const NearestPoint q = field_.nearest(p, max_distance + rounding_);
    if (nearest) *nearest = q;
    if (!std::isfinite(q.distance)) return -max_distance;
    return field_.isInside(p, q) ? -q.distance : q.distance;
  }

 private:
  const DistanceField& field_;
  const SphereUnion& balls_;
  std::vector<double> reach_;
  double rounding_ = 0;
};

/// Direction `k` of `count` on the spherical Fibonacci lattice: equal areas, nearly even spacing.
/// Paper: R. Swinbank, R. J. Purser. Fibonacci grids: a novel approach to global modelling. Q. J. R. Meteorol. Soc.
///         132, 2006.
Vector3d latticeDirection(std::size_t k, std::size_t count) {
  const double z = 1 - (2 * static_cast<double>(k) + 1) / static_cast<double>(count);
  const double turn = static_cast<double>(k) * std::numbers::phi;
  const double angle = 2 * std::numbers::pi * (turn - std::floor(turn));
  const double across = std::sqrt(std::max(0.0, (1 - z) * (1 + z)));
  return {across * std::cos(angle), across * std::sin(angle), z};
}

Vector3d anyPerpendicular(const Vector3d& u) {
  int axis = 0;
  u.cwiseAbs().minCoeff(&axis);
  return u.cross(Vector3d::Unit(axis)).normalized();
}

/// Moves a direction of ball `i` that other balls cover to the nearby circle or corner where their cover ends; false if
/// that place is covered, too.
bool slideToBoundary(const SphereUnion& balls, std::size_t i, Vector3d& u) {
  const SphereUnion::Cap* first = balls.capOver(i, u);
  if (!first) return true;
  if (std::abs(first->cosine) >= 1) return false;
  const Vector3d across = u - u.dot(first->axis) * first->axis;
  if (!(across.norm() > 1e-12)) return false;
  const Vector3d on_circle = first->cosine * first->axis + std::sqrt(1 - first->cosine * first->cosine) * across.normalized();
  const SphereUnion::Cap* second = balls.capOver(i, on_circle);
  if (!second) {
    u = on_circle.normalized();
    return true;
  }
  // The two directions with u . a = cos_a and u . b = cos_b.
  const Vector3d &a = first->axis, &b = second->axis, normal = a.cross(b);
  const double ab = a.dot(b), sine2 = normal.squaredNorm();
  if (!(sine2 > 1e-12)) return false;
  const Vector3d in_plane = ((first->cosine - second->cosine * ab) * a + (second->cosine - first->cosine * ab) * b) / sine2;
  const double height2 = (1 - in_plane.squaredNorm()) / sine2;
  if (!(height2 >= 0)) return false;
  const double height = std::sqrt(height2);
  u = (in_plane + (u.dot(normal) >= 0 ? height : -height) * normal).normalized();
  return !balls.capOver(i, u);
}

/// Climbs on the boundary of the union from `place` to a local maximum of the overhang: pattern search with eight
/// directions, which are rotated in each round, along the circles where two balls meet and into the corners where three
/// meet.
void climb(const Overhangs& overhangs, Summit& place) {
  constexpr int kRounds = 120, kDirections = 8;
  const double last = 1e-6 * place.spacing;
  for (int round = 0; round < kRounds && place.spacing > last; ++round) {
    const Vector3d side = anyPerpendicular(place.direction), up = place.direction.cross(side);
    Summit best = place;
    for (int k = 0; k < kDirections; ++k) {
      const double angle = 2 * std::numbers::pi * (k + 0.382 * round) / kDirections;
      Vector3d u = (place.direction + place.spacing * (std::cos(angle) * side + std::sin(angle) * up)).normalized();
      if (!slideToBoundary(overhangs.balls(), place.ball, u)) continue;
      const double overhang = overhangs.at(place.ball, u, overhangs.reach(place.ball));
      if (overhang > best.overhang) best.overhang = overhang, best.direction = u;
    }
    if (best.overhang > place.overhang)
      place = best;
    else
      place.spacing *= 0.5;
  }
}

struct Sampled {
  std::vector<Summit> best;     // the highest place in each run of adjacent outside samples of a ball
  std::vector<float> values;    // overhang of each outside sample [mm]
  std::vector<double> weights;  // area that each of them represents [mm^2]
};

Sampled sampleBoundary(const Overhangs& overhangs, const OverhangSettings& settings, Progress& progress) {
  const SphereUnion& balls = overhangs.balls();
  double squares = 0;
  for (std::size_t i = 0; i < balls.size(); ++i)
    if (!balls.isHidden(i)) squares += balls.balls()[i].radius * balls.balls()[i].radius;
  struct Run {
    std::uint32_t ball;
    std::size_t count, first, last;  // range within the `count` directions of the ball
  };
  constexpr std::size_t kRun = 1024;
  std::vector<Run> runs;
  for (std::size_t i = 0; i < balls.size(); ++i) {
    if (balls.isHidden(i) || overhangs.reach(i) <= 0) continue;
    const double radius = balls.balls()[i].radius, share = radius * radius / squares;
    const auto count = std::clamp(static_cast<std::size_t>(std::ceil(static_cast<double>(settings.samples) * share)), settings.min_per_ball,
                                  settings.max_per_ball);
    for (std::size_t k = 0; k < count; k += kRun) runs.push_back({static_cast<std::uint32_t>(i), count, k, std::min(k + kRun, count)});
  }

  std::vector<std::vector<float>> values(runs.size());
  std::vector<Summit> best(runs.size());
  tbb::parallel_for(std::size_t{0}, runs.size(), [&](std::size_t r) {
    if (progress.cancelled()) return;
    const Run& run = runs[r];
    best[r].ball = run.ball;
    for (std::size_t k = run.first; k < run.last; ++k) {
      const Vector3d u = latticeDirection(k, run.count);
      if (balls.capOver(run.ball, u)) continue;
      const double overhang = overhangs.at(run.ball, u, overhangs.reach(run.ball));
      if (!(overhang > 0)) continue;
      values[r].push_back(static_cast<float>(overhang));
      if (overhang > best[r].overhang) best[r].overhang = overhang, best[r].direction = u;
    }
  });
  progress.check();

  Sampled out;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const Run& run = runs[r];
    const double radius = balls.balls()[run.ball].radius;
    const double share = 4 * std::numbers::pi / static_cast<double>(run.count);
    out.values.insert(out.values.end(), values[r].begin(), values[r].end());
    out.weights.insert(out.weights.end(), values[r].size(), share * radius * radius);
    best[r].spacing = std::sqrt(share);
    if (best[r].overhang > 0) out.best.push_back(best[r]);
  }
  return out;
}

void summarise(const Sampled& sampled, Overhang& out) {
  std::vector<std::uint32_t> order(sampled.values.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return sampled.values[a] != sampled.values[b] ? sampled.values[a] > sampled.values[b] : a < b;
  });
  double sum = 0;
  for (const std::uint32_t i : order) {
    out.outside_area += sampled.weights[i];
    sum += sampled.weights[i] * static_cast<double>(sampled.values[i]);
  }
  if (order.empty()) return;
  out.mean = sum / out.outside_area;
  double above = 0;
  for (const std::uint32_t i : order) {
    out.p99 = static_cast<double>(sampled.values[i]);
    above += sampled.weights[i];
    if (above > 0.01 * out.outside_area) break;
  }
}

/// A spherical triangle on the surface of a ball whose overhang has to be bounded.
struct Patch {
  std::array<Vector3d, 3> corner;  // unit directions
  std::uint32_t ball = 0;
  std::uint32_t triangle = 0;  // of the mesh: nearest to the middle of the parent patch
  double bound = 0;            // of the overhang over the patch [mm]
};

struct PatchVerdict {
  bool done = true;            // proven: in another ball, or below the threshold
  double bound = 0;            // proven bound of its overhang; 0 if it is in another ball
  std::uint32_t triangle = 0;  // nearest to the middle
  double middle = 0;           // overhang of the middle, if that is on the boundary [mm]
};

/// Upper bound of the overhang over a patch of a ball, from a single triangle of the mesh. The distance to a convex set
/// is a convex function, so over the hull of some points it is largest at one of them. The patch lies in the hull of
/// its corners u and of u / flatness: each of its points is y / |y|, with y on the flat triangle and flatness <= |y| <=
/// 1.
double boundByTriangle(const Overhangs& overhangs, const Patch& patch, double flatness, const std::array<Vector3d, 3>& triangle) {
  double largest = 0;
  for (const Vector3d& u : patch.corner)
    for (const double scale : {1.0, 1.0 / flatness})
      largest =
          std::max(largest, nearestOnTriangle(overhangs.point(patch.ball, scale * u), triangle[0], triangle[1], triangle[2]).distance);
  return largest + overhangs.rounding();
}

PatchVerdict judge(const Overhangs& overhangs, const Patch& patch, double threshold) {
  const auto& [a, b, c] = patch.corner;
  const Vector3d middle = (a + b + c).normalized();
  // Of the flat triangle, the corners are nearest to the plane through the centre that is perpendicular to `middle`.
  const double flatness = std::min({a.dot(middle), b.dot(middle), c.dot(middle)}) * (1 - 1e-15);
  PatchVerdict out;
  if (overhangs.balls().isBuried(patch.ball, a, b, c, flatness)) return out;
  const DistanceField& field = overhangs.field();
  out.triangle = patch.triangle;
  out.bound = patch.bound;
  if (patch.triangle != kNoTriangle)
    out.bound = std::min(out.bound, boundByTriangle(overhangs, patch, flatness, field.corners(patch.triangle)));
  if (out.bound <= threshold) return out;

  // Outside points of the patch have a distance of at most patch.bound.
  NearestPoint nearest;
  const double height = overhangs.at(patch.ball, middle, patch.bound, &nearest);
  const double chord = std::sqrt(std::max({(a - middle).squaredNorm(), (b - middle).squaredNorm(), (c - middle).squaredNorm()}));
  out.bound = std::min(out.bound, height + overhangs.balls().balls()[patch.ball].radius * chord * (1 + 1e-15) + overhangs.rounding());
  if (out.bound <= threshold) return out;
  if (std::isfinite(nearest.distance)) {
    if (nearest.triangle != patch.triangle)
      out.bound = std::min(out.bound, boundByTriangle(overhangs, patch, flatness, field.corners(nearest.triangle)));
    out.triangle = nearest.triangle;
  }
  out.done = out.bound <= threshold;
  if (height > 0 && !overhangs.balls().capOver(patch.ball, middle)) out.middle = height;
  return out;
}

/// The four quarters of the triangle, by the middles of its sides.
std::array<Patch, 4> cut(const Patch& patch) {
  const auto& [a, b, c] = patch.corner;
  const Vector3d ab = (a + b).normalized(), bc = (b + c).normalized(), ca = (c + a).normalized();
  std::array<Patch, 4> out{patch, patch, patch, patch};
  out[0].corner = {a, ab, ca};
  out[1].corner = {ab, b, bc};
  out[2].corner = {ca, bc, c};
  out[3].corner = {ab, bc, ca};
  return out;
}

/// Searches the highest place of the boundary by climbing, and proves a bound of it by branch and bound over patches of
/// all balls.
class HighestSearch {
 public:
  HighestSearch(const Overhangs& overhangs, const OverhangSettings& settings, Progress& progress)
      : overhangs_(overhangs), settings_(settings), progress_(progress) {}

  const Summit& highest() const { return highest_; }

  /// Climbs from the highest `max_count` of the places, and keeps the highest place reached.
  void climbFrom(std::vector<Summit>& starts, std::size_t max_count) {
    std::stable_sort(starts.begin(), starts.end(), [](const Summit& a, const Summit& b) { return a.overhang > b.overhang; });
    if (starts.size() > max_count) starts.resize(max_count);
    tbb::parallel_for(std::size_t{0}, starts.size(), [&](std::size_t i) {
      if (!progress_.cancelled()) climb(overhangs_, starts[i]);
    });
    progress_.check();
    for (const Summit& place : starts)
      if (place.overhang > highest_.overhang) highest_ = place;
  }

  /// Returns a bound of the overhang of all balls. Breadth first and in rounds, so that the result does not depend on
  /// the threads.
  double prove() {
    std::vector<Patch> patches = octants();
    double proven = 0;  // bound over all decided patches
    double spacing = 0.5;
    std::size_t judged = 0;
    std::vector<PatchVerdict> verdicts;
    while (!patches.empty()) {
      const double limit = threshold();
      judged += patches.size();
      if (judged > settings_.max_patches) {
        for (const Patch& patch : patches) proven = std::max(proven, patch.bound);
        break;
      }
      verdicts.assign(patches.size(), {});
      forEachIndex(patches.size(), progress_, [&](std::size_t i) { verdicts[i] = judge(overhangs_, patches[i], limit); });
      patches = cutUndecided(patches, verdicts, spacing, proven);
      spacing *= 0.5;
    }
    return proven;
  }

 private:
  /// Patches with an overhang up to this need no further proof [mm].
  double threshold() const {
    return std::max(highest_.overhang * (1 + settings_.relative_gap),
                    highest_.overhang + settings_.absolute_gap * overhangs_.field().diagonal());
  }

  std::vector<Patch> octants() const {
    std::vector<Patch> patches;
    for (std::size_t i = 0; i < overhangs_.balls().size(); ++i) {
      if (overhangs_.balls().isHidden(i) || overhangs_.reach(i) <= 0) continue;
      for (const double x : {1.0, -1.0})
        for (const double y : {1.0, -1.0})
          for (const double z : {1.0, -1.0})
            patches.push_back({{x * Vector3d::UnitX(), y * Vector3d::UnitY(), z * Vector3d::UnitZ()},
                               static_cast<std::uint32_t>(i),
                               kNoTriangle,
                               overhangs_.reach(i)});
    }
    return patches;
  }

  /// Climbs from the high undecided patches and returns their quarters; raises `proven` by the bounds of the decided
  /// patches.
  std::vector<Patch> cutUndecided(const std::vector<Patch>& patches, const std::vector<PatchVerdict>& verdicts, double spacing,
                                  double& proven) {
    std::vector<Patch> next;
    std::vector<Summit> starts;
    for (std::size_t i = 0; i < patches.size(); ++i) {
      const PatchVerdict& verdict = verdicts[i];
      if (verdict.done) {
        proven = std::max(proven, verdict.bound);
        continue;
      }
      if (verdict.middle > kWorthAClimb * highest_.overhang) {
        const auto& corner = patches[i].corner;
        const Summit place{patches[i].ball, (corner[0] + corner[1] + corner[2]).normalized(), verdict.middle, spacing};
        if (starts.empty() || starts.back().ball != place.ball)
          starts.push_back(place);
        else if (place.overhang > starts.back().overhang)  // one start for each ball suffices
          starts.back() = place;
      }
      for (Patch& part : cut(patches[i])) {
        part.triangle = verdict.triangle;
        part.bound = verdict.bound;
        next.push_back(part);
      }
    }
    climbFrom(starts, kClimbsARound);
    return next;
  }

  const Overhangs& overhangs_;
  const OverhangSettings& settings_;
  Progress& progress_;
  Summit highest_;
};

}  // namespace

Overhang measureOverhang(const DistanceField& field, const SphereUnion& balls, const OverhangSettings& settings, Progress& progress) {
  if (settings.min_per_ball == 0 || settings.max_per_ball < settings.min_per_ball || !(settings.relative_gap >= 0) ||
      !(settings.absolute_gap > 0))
    throw std::invalid_argument("overhang: settings out of range");
  Overhang out;
  if (balls.size() == 0) return out;
  const Overhangs overhangs(field, balls);
  Sampled sampled = sampleBoundary(overhangs, settings, progress);
  summarise(sampled, out);

  HighestSearch search(overhangs, settings, progress);
  search.climbFrom(sampled.best, kFirstClimbs);
  const double proven = search.prove();
  const Summit& highest = search.highest();
  out.max = highest.overhang;
  out.bound = std::max(proven, out.max);
  if (out.max > 0) out.worst_ball = highest.ball, out.worst_point = overhangs.point(highest.ball, highest.direction);
  return out;
}

}  // namespace spheretree::builder
