// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/fit_hulls.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "certify/triangle_piece.h"
#include "geometry/surface_samples.h"
#include "hulls/hull_cover.h"
#include "hulls/hull_overhang.h"
#include "spheretree/core/rounding.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kSamples = 4000;      // of the surface, for the pool of balls
constexpr std::size_t kMaxPool = 600;       // balls in the pool
constexpr double kSpacing = 0.3;            // of the balls of the pool, and first step of their moves, as shares of their radii
constexpr double kSteepest = 0.99;          // of a hull: well below kSteepestHull, so that rounding cannot reach that
constexpr double kAccuracy = 0.02;          // of the overhang of a candidate, as a share of the tolerance
constexpr std::size_t kEstimate = 16;       // steps along a side for the estimate of the overhang of a candidate; a power of two
constexpr double kCoarse = 4, kFine = 0.5;  // sides of pieces, as multiples of the length over which a ball is flat within the tolerance
constexpr double kWorthASlab = 1.3;         // a slab has to gain this much more than a cone
constexpr double kThinnest = 0.05;          // height of a slab's triangle over its longest side
constexpr double kDeeper = 1.3;             // factor from depth to depth below a point of the surface
constexpr double kCentred = 1e-4;           // last step of the centring of balls, as a share of their radii
constexpr int kHalvings = 7;                // of the steps of a climb

struct OpenPiece {
  Piece piece;
  double area, fine;  // it is not split below this side to be cut out of a hull
};

struct Candidate {
  std::vector<Vector3d> centres;
  Hull hull;
  double gain = -1;  // area of the open pieces in the hull; below 0: not a hull that holds the first piece within the tolerance
};

double areaOf(const Piece& piece) { return 0.5 * (piece.corner[1] - piece.corner[0]).cross(piece.corner[2] - piece.corner[0]).norm(); }

// Strips parallel to the shortest side. Halving alone would cut a sliver into many more pieces, each thinner than it.
std::vector<Piece> stripsOf(const Piece& piece, double width) {
  const std::size_t k = shortestSide(piece);
  const Vector3d &apex = piece.corner[k], &b = piece.corner[(k + 1) % 3], &c = piece.corner[(k + 2) % 3];
  const double count = std::ceil(std::sqrt(side2(piece, longestSide(piece))) / width);
  std::vector<Piece> strips;
  Vector3d b_before = apex, c_before = apex;
  for (double i = 1; i <= count; ++i) {
    const Vector3d b_here = i < count ? Vector3d(apex + i / count * (b - apex)) : b,
                   c_here = i < count ? Vector3d(apex + i / count * (c - apex)) : c;
    strips.push_back({{b_before, b_here, c_here}});
    if (i > 1) strips.push_back({{b_before, c_here, c_before}});
    b_before = b_here, c_before = c_here;
  }
  return strips;
}

// The deepest ball below a point of the surface that leaves at most `tolerance` between them; radius 0 if there is
// none. Balls that touch the surface would be far smaller below flat facets than the surface is thick.
Ball ballBelowPoint(const DistanceField& field, const Vector3d& point, const Vector3d& normal, double tolerance) {
  Ball best{point, 0};
  const auto reaches = [&](double depth) {
    const Vector3d c = point - depth * normal;
    const double radius = -field.signedDistance(c);
    if (!(radius >= depth - tolerance && radius > 0)) return false;
    best = {c, radius};
    return true;
  };
  double low = tolerance, high = kDeeper * low;
  while (reaches(high)) low = high, high *= kDeeper;
  for (int halving = 0; halving < kHalvings; ++halving) {
    const double middle = 0.5 * (low + high);
    (reaches(middle) ? low : high) = middle;
  }
  return best;
}

// Moved a little to where the surface is farther away: a long cone stays within the tolerance only if it is centred.
Ball centred(const DistanceField& field, Ball ball) {
  const Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  for (double step = kSpacing * ball.radius; step > kCentred * ball.radius; step *= 0.5) {
    Ball best = ball;
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      for (const double sign : {1.0, -1.0}) {
        const Vector3d c = ball.centre + sign * step * axes.col(axis);
        if (const double radius = -field.signedDistance(c); radius > best.radius) best = {c, radius};
      }
    ball = best;
  }
  return ball;
}

// Such balls below samples, the largest first, none of them near the centre of a larger one.
std::vector<Ball> poolOf(const TriangleMesh& mesh, const DistanceField& field, double tolerance, std::uint64_t seed) {
  SampleSettings settings;
  settings.count = kSamples, settings.seed = seed;
  const std::vector<SurfaceSample> samples = sampleSurface(mesh, settings);
  std::vector<Ball> balls(samples.size());
  tbb::parallel_for(std::size_t{0}, samples.size(),
                    [&](std::size_t i) { balls[i] = ballBelowPoint(field, samples[i].point, samples[i].normal, 0.5 * tolerance); });
  std::ranges::stable_sort(balls, std::ranges::greater{}, &Ball::radius);
  std::vector<Ball> pool;
  for (double spacing = kSpacing;; spacing *= 1.3) {
    pool.clear();
    for (const Ball& ball : balls)
      if (ball.radius > 0 &&
          std::ranges::none_of(pool, [&](const Ball& kept) { return (kept.centre - ball.centre).norm() < spacing * ball.radius; }))
        pool.push_back(ball);
    if (pool.size() <= kMaxPool) break;
  }
  tbb::parallel_for(std::size_t{0}, pool.size(), [&](std::size_t i) { pool[i] = centred(field, pool[i]); });
  return pool;
}

class HullFit {
 public:
  HullFit(const TriangleMesh& mesh, const DistanceField& field, const FitSettings& settings, Progress& progress)
      : mesh_(mesh), field_(field), settings_(settings), progress_(progress), margin_(kAccuracy * settings.tolerance + settings.rounding) {}

  std::vector<Hull> run() {
    pool_ = poolOf(mesh_, field_, settings_.tolerance, settings_.seed);
    openAll();
    std::vector<Hull> hulls;
    while (!open_.empty()) {
      progress_.check();
      if (hulls.size() == settings_.max_hulls) return {};
      hulls.push_back(next());
      close(hulls.back());
    }
    return withoutRedundant(hulls);
  }

 private:
  // The triangles, cut to pieces short enough that their corners say which part of them a hull holds.
  void openAll() {
    std::vector<Piece> stack;
    Vector3d middle = Vector3d::Zero();
    double area = 0;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      const Piece triangle = pieceOf(mesh_, t, Vector3d::Zero());
      if (!(areaOf(triangle) > 0)) continue;
      const double radius = ballBelow(triangle).radius;
      const double flat = std::sqrt(std::max(radius, settings_.tolerance) * settings_.tolerance);
      stack = stripsOf(triangle, kCoarse * flat);
      while (!stack.empty()) {
        const Piece piece = stack.back();
        stack.pop_back();
        const std::size_t k = longestSide(piece);
        if (side2(piece, k) > kCoarse * flat * kCoarse * flat) {
          for (const Piece& half : halvesOf(piece, k)) stack.push_back(half);
          continue;
        }
        open_.push_back({piece, areaOf(piece), kFine * flat});
        middle += open_.back().area * centroidOf(piece);
        area += open_.back().area;
      }
    }
    middle /= area;
    for (const OpenPiece& open : open_)
      for (const Vector3d& p : open.piece.corner)
        if ((p - middle).squaredNorm() > (start_ - middle).squaredNorm() || !has_start_) start_ = p, has_start_ = true;
  }

  Ball ballBelow(const Piece& piece) const {
    const Vector3d across = (piece.corner[1] - piece.corner[0]).cross(piece.corner[2] - piece.corner[0]);
    return ballBelowPoint(field_, centroidOf(piece), across.normalized(), 0.5 * settings_.tolerance);
  }

  // The hull that gains most among those that hold the open piece nearest to the start. The pieces are thereby taken
  // from one end to the other, and no strips are left between hulls that would need hulls of their own.
  Hull next() {
    const auto key = [&](const OpenPiece& open) { return (centroidOf(open.piece) - start_).squaredNorm(); };
    const auto first = std::ranges::min_element(open_, {}, key);
    std::swap(*first, open_.back());
    for (;;) {
      seed_ = open_.back().piece;
      findBlocks();
      if (Candidate ball = bestBall(); ball.gain >= 0) {
        const Candidate cone = climb(extended(ball));
        Candidate slab = extended(cone);
        if (slab.centres.size() > cone.centres.size()) slab = climb(std::move(slab));
        if (slab.gain > kWorthASlab * cone.gain)
          if (const std::optional<Hull> hull = proven(slab)) return *hull;
        if (const std::optional<Hull> hull = proven(cone)) return *hull;
        if (const std::optional<Hull> hull = proven(ball)) return *hull;
      }
      // No hull holds the whole piece: a smaller one is held by a ball about its middle at last.
      OpenPiece open = open_.back();
      open_.pop_back();
      open.area *= 0.5;
      for (const Piece& half : halvesOf(open.piece, longestSide(open.piece))) {
        open.piece = half;
        open_.push_back(open);
      }
    }
  }

  // Neighbours in the list are neighbours on the surface, so that most candidates meet few blocks.
  void findBlocks() {
    block_size_ = static_cast<std::size_t>(std::sqrt(static_cast<double>(open_.size())));
    block_.assign(open_.size() / block_size_ + 1, Eigen::AlignedBox3d());
    for (std::size_t i = 0; i < open_.size(); ++i) block_[i / block_size_].extend(open_[i].piece.corner[0]);
  }

  Candidate bestBall() const {
    std::vector<std::vector<Vector3d>> tried;
    const Vector3d middle = centroidOf(seed_);
    for (const Ball& ball : pool_)
      if ((ball.centre - middle).norm() < ball.radius + settings_.tolerance) tried.push_back({ball.centre});
    if (const Ball ball = ballBelow(seed_); ball.radius > 0) tried.push_back({ball.centre});
    tried.push_back({middle});
    return bestOf(tried);
  }

  // With one more ball of the pool, if that gains.
  Candidate extended(const Candidate& from) const {
    if (from.centres.size() == 3) return from;
    std::vector<std::vector<Vector3d>> tried;
    for (const Ball& ball : pool_) {
      tried.push_back(from.centres);
      tried.back().push_back(ball.centre);
    }
    Candidate best = bestOf(tried);
    return best.gain > from.gain ? best : from;
  }

  // Moves the centres, one at a time, as long as that gains.
  Candidate climb(Candidate best) const {
    double step = kSpacing;
    for (int halving = 0; halving < kHalvings; ++halving, step *= 0.5) {
      for (;;) {
        std::vector<std::vector<Vector3d>> tried;
        const Eigen::Matrix3d axes = axesOf(best);
        for (std::size_t k = 0; k < best.centres.size(); ++k)
          for (const double sign : {1.0, -1.0})
            for (Eigen::Index axis = 0; axis < 3; ++axis) {
              tried.push_back(best.centres);
              tried.back()[k] += sign * step * best.hull.ball[k].radius * axes.col(axis);
            }
        Candidate moved = bestOf(tried);
        if (!(moved.gain > best.gain * (1 + kRounding))) break;
        best = std::move(moved);
      }
    }
    return best;
  }

  // Along the hull and across it; they turn with the mesh.
  Eigen::Matrix3d axesOf(const Candidate& candidate) const {
    const Vector3d a = candidate.centres[0], seed = centroidOf(seed_) - a;
    Vector3d along = candidate.centres.size() > 1 ? Vector3d(candidate.centres[1] - a) : Vector3d(seed_.corner[1] - seed_.corner[0]);
    along.normalize();
    Vector3d across = candidate.centres.size() > 2 ? Vector3d(candidate.centres[2] - a) : seed;
    across -= across.dot(along) * along;
    if (!(across.norm() > 1e-9)) across = along.unitOrthogonal();
    across.normalize();
    Eigen::Matrix3d axes;
    axes << along, across, along.cross(across);
    return axes;
  }

  // Ties go to the first.
  Candidate bestOf(const std::vector<std::vector<Vector3d>>& tried) const {
    std::vector<Candidate> made(tried.size());
    tbb::parallel_for(std::size_t{0}, tried.size(), [&](std::size_t i) { made[i] = candidate(tried[i]); });
    Candidate best;
    for (Candidate& c : made)
      if (c.gain > best.gain) best = std::move(c);
    return best;
  }

  // The hull of the largest inscribed balls about the centres, all grown by what the tolerance leaves: with larger
  // radii, the overhang of a hull grows by as much.
  Candidate candidate(const std::vector<Vector3d>& centres) const {
    Candidate out{centres, {}, -1};
    Hull& hull = out.hull;
    hull.count = centres.size();
    for (std::size_t k = 0; k < centres.size(); ++k) hull.ball[k] = {centres[k], std::max(0.0, -field_.signedDistance(centres[k]))};
    if (!(steepness(hull) < kSteepest) || (hull.count == 3 && isThin(centres))) return out;
    const double left = settings_.tolerance - margin_ - estimatedOverhang(hull);
    if (!(left > 0)) return out;
    for (std::size_t k = 0; k < hull.count; ++k) hull.ball[k].radius += left;
    const HullDistance distance(hull);
    const auto isIn = [&](const Vector3d& p) { return distance(p) <= -margin_; };
    if (!std::ranges::all_of(seed_.corner, isIn)) return out;
    const Eigen::AlignedBox3d box = boxOf(hull);
    out.gain = 0;
    for (std::size_t block = 0; block < block_.size(); ++block) {
      if (!box.intersects(block_[block])) continue;
      for (std::size_t i = block * block_size_; i < std::min(open_.size(), (block + 1) * block_size_); ++i)
        if (box.contains(open_[i].piece.corner[0]))
          out.gain += open_[i].area * static_cast<double>(std::ranges::count_if(open_[i].piece.corner, isIn));
    }
    return out;
  }

  // The largest overhang of some balls of the hull; infinite once it exceeds the tolerance. A proof for each of the
  // many candidates would take a hundred times as long.
  double estimatedOverhang(const Hull& hull) const {
    double largest = 0;
    const auto isWithin = [&](double w1, double w2) {
      const double w0 = 1 - w1 - w2;
      const auto& [a, b, c] = hull.ball;
      const double overhang =
          w0 * a.radius + w1 * b.radius + w2 * c.radius + field_.signedDistance(w0 * a.centre + w1 * b.centre + w2 * c.centre);
      largest = std::max(largest, overhang);
      return overhang < settings_.tolerance;
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

  // The hull of a candidate, with its overhang proven; none if it then no longer holds the first piece.
  std::optional<Hull> proven(const Candidate& candidate) const {
    Hull hull = candidate.hull;
    const HullOverhangSettings search{.absolute = kAccuracy * settings_.tolerance};
    const double excess = hullOverhang(field_, hull, search).bound - (settings_.tolerance - settings_.rounding);
    for (std::size_t k = 0; k < hull.count; ++k) {
      hull.ball[k].radius -= std::max(0.0, excess);
      if (!(hull.ball[k].radius > 0)) return {};
    }
    const HullDistance distance(hull);
    const bool holds = std::ranges::all_of(seed_.corner, [&](const Vector3d& p) { return distance(p) <= -margin_; });
    return holds ? std::optional(hull) : std::nullopt;
  }

  static bool isThin(const std::vector<Vector3d>& c) {
    const double longest = std::max({(c[1] - c[0]).squaredNorm(), (c[2] - c[1]).squaredNorm(), (c[0] - c[2]).squaredNorm()});
    return (c[1] - c[0]).cross(c[2] - c[0]).norm() < kThinnest * longest;
  }

  // Removes what the hull holds. A piece that it holds in part is split first.
  void close(const Hull& hull) {
    const HullDistance distance(hull);
    std::vector<OpenPiece> stack;
    stack.swap(open_);
    while (!stack.empty()) {
      OpenPiece open = stack.back();
      stack.pop_back();
      const auto held = std::ranges::count_if(open.piece.corner, [&](const Vector3d& p) { return distance(p) <= -margin_; });
      if (held == 3) continue;
      const std::size_t k = longestSide(open.piece);
      if (held == 0 || side2(open.piece, k) < open.fine * open.fine) {
        open_.push_back(open);
        continue;
      }
      open.area *= 0.5;
      for (const Piece& half : halvesOf(open.piece, k)) {
        open.piece = half;
        stack.push_back(open);
      }
    }
  }

  std::vector<Hull> withoutRedundant(std::vector<Hull> hulls) const {
    for (std::size_t i = hulls.size(); i-- > 0;) {
      const HullCover cover(hulls, 0.5 * margin_);
      const Eigen::AlignedBox3d box = boxOf(hulls[i]);
      std::vector<char> bare(mesh_.triangles.size(), 0);
      tbb::parallel_for(std::size_t{0}, bare.size(), [&](std::size_t t) {
        const Piece triangle = pieceOf(mesh_, t, Vector3d::Zero());
        Eigen::AlignedBox3d own;
        for (const Vector3d& p : triangle.corner) own.extend(p);
        if (box.intersects(own)) bare[t] = !cover.holds(triangle, i);
      });
      if (std::ranges::count(bare, 1) == 0) hulls.erase(hulls.begin() + static_cast<std::ptrdiff_t>(i));
    }
    return hulls;
  }

  const TriangleMesh& mesh_;
  const DistanceField& field_;
  const FitSettings& settings_;
  Progress& progress_;
  double margin_;  // how deep a point has to lie in a hull to count as held [mm]
  std::vector<Ball> pool_;
  std::vector<OpenPiece> open_;
  std::vector<Eigen::AlignedBox3d> block_;  // of the first corners of each block of open pieces
  std::size_t block_size_ = 0;
  Vector3d start_ = Vector3d::Zero();
  bool has_start_ = false;
  Piece seed_;
};

}  // namespace

std::vector<Hull> fitHulls(const TriangleMesh& mesh, const DistanceField& field, const FitSettings& settings, Progress& progress) {
  if (kAccuracy * settings.tolerance < settings.rounding) return {};
  return HullFit(mesh, field, settings, progress).run();
}

}  // namespace spheretree::builder
