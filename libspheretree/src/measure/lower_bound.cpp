// SPDX-License-Identifier: GPL-3.0-or-later
#include "measure/lower_bound.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <stdexcept>

#include "base/ball.h"
#include "base/sum_in_order.h"
#include "geometry/box_tree.h"
#include "measure/cover_limits.h"
#include "measure/coverage.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kPointsASphere = 150, kMinBoundPoints = 4000, kMaxBoundPoints = 400'000;
constexpr std::size_t kMedialASphere = 24;  // medial balls that the weights are balanced over
constexpr int kBalanceRounds = 160;         // steps of the weights
constexpr double kGuard = 0.2;              // of the overhang: by how much larger the balls are that the weights are balanced over
constexpr double kFirstSoftness = 0.2, kLastSoftness = 0.03;  // of the penalty on full balls, at the first and the last step
constexpr double kFullBall = 1.03;                            // weight that the proof lets a ball have
constexpr double kUndecided = 0.08;                           // share of the weight of a cell that may stay undecided
constexpr std::size_t kWitnesses = 16;                        // points beyond the overhang that a cell is tested with
constexpr double kSmallestCell = 0.06;                        // of the radius of a disc that a ball cuts out of a face
constexpr std::size_t kParallelCell = 256;                    // a cell with more undecided points is divided by several threads

double roundingOf(const DistanceField& field) {
  return 1e-12 * std::max(field.box().min().cwiseAbs().maxCoeff(), field.box().max().cwiseAbs().maxCoeff());
}

/// A point outside that is farther than `overhang` from the surface, so that no ball of that overhang holds it: near
/// `c`, on the line through the nearest surface point. False if there is none nearby.
bool findWitness(const DistanceField& field, const Vector3d& c, double overhang, Vector3d& witness) {
  constexpr int kSteps = 16;
  const double rounding = roundingOf(field), least = overhang + rounding;
  NearestPoint q;
  const double d = field.signedDistance(c, &q);
  witness = c;
  if (d > least) return true;
  Vector3d out = d > 0 ? Vector3d(c - q.point) : Vector3d(q.point - c);
  out = out.norm() > 4 * rounding ? Vector3d(out.normalized()) : field.pseudonormal(q);
  witness = q.point + (overhang * (1 + 1e-7) + 2 * rounding) * out;
  for (int step = 0; step < kSteps; ++step) {
    const double height = field.signedDistance(witness);
    if (height > least) return true;
    witness += (1.001 * least - height) * out;  // a little too far, since the distance may grow more slowly than the way
  }
  return false;
}

}  // namespace

/// Witnesses near every part of the surface. The line from a centre through its nearest surface point may lead into a
/// crack or a fold where no witness is, and leave the solid far away.
class WitnessIndex {
 public:
  WitnessIndex(const DistanceField& field, const SampleIndex& points, double overhang) : field_(field), overhang_(overhang) {
    std::vector<char> found(points.size());
    witnesses_.resize(points.size());
    forEachIndex(points.size(), [&](std::size_t i) { found[i] = findWitness(field, points[i], overhang, witnesses_[i]); });
    std::vector<Vector3d> all;
    std::vector<Eigen::AlignedBox3d> boxes;
    for (std::size_t i = 0; i < found.size(); ++i)
      if (found[i]) all.push_back(witnesses_[i]), boxes.emplace_back(all.back(), all.back());
    tree_ = BoxTree(boxes, 8);
    witnesses_.clear();
    for (const std::uint32_t i : tree_.order()) witnesses_.push_back(all[i]);
  }

  /// Up to two near `c`: the one on the line, and the nearest of the index.
  std::vector<Vector3d> near(const Vector3d& c) const {
    std::vector<Vector3d> out;
    if (Vector3d on_line; findWitness(field_, c, overhang_, on_line)) out.push_back(on_line);
    double nearest2 = kInfinity;
    Vector3d nearest;
    tree_.searchNearest(c, nearest2, [&](std::size_t first, std::size_t count) {
      for (std::size_t i = first; i < first + count; ++i)
        if (const double d2 = (witnesses_[i] - c).squaredNorm(); d2 < nearest2) nearest2 = d2, nearest = witnesses_[i];
    });
    if (nearest2 < kInfinity) out.push_back(nearest);
    return out;
  }

 private:
  const DistanceField& field_;
  double overhang_;
  BoxTree tree_;
  std::vector<Vector3d> witnesses_;  // in the order of the tree
};

namespace {

/// Proves by division of space that no ball holds too much weight, and lowers weights where that fails.
class BallWeights {
 public:
  BallWeights(const DistanceField& field, const WitnessIndex& witnesses, const SampleIndex& points, const std::vector<double>& weight,
              double overhang, const Progress& progress)
      : field_(field),
        witnesses_(witnesses),
        points_(points),
        weight_(weight),
        overhang_(overhang),
        rounding_(roundingOf(field)),
        progress_(progress) {
    share_.assign(weight.size(), 1.0);
  }

  /// Factors by which the weights are to be multiplied: then no ball holds more than kFullBall.
  const std::vector<double>& prove() {
    const Eigen::AlignedBox3d& box = field_.box();
    Cell all;
    all.centre = box.center();
    all.half = 0.5 * box.sizes().maxCoeff() + 2 * overhang_;
    for (std::uint32_t i = 0; i < weight_.size(); ++i)
      if (weight_[i] > 0) all.maybe.push_back(i), all.maybe_weight += weight_[i];
    divide(all);
    progress_.check();
    return share_;
  }

 private:
  struct Cell {
    Vector3d centre = Vector3d::Zero();      // of a cube
    double half = 0;                         // half of its side
    std::vector<std::uint32_t> sure, maybe;  // points that a ball with its centre in the cube may hold; `sure` are not tested again
    double sure_weight = 0, maybe_weight = 0;
    std::vector<Vector3d> witnesses;
  };

  void divide(const Cell& cell) {
    if (progress_.cancelled()) return;
    const double weight = cell.sure_weight + cell.maybe_weight;
    if (weight <= kFullBall) return;
    if (cell.maybe_weight <= kUndecided * weight || isSmall(cell)) return lower(cell, kFullBall / weight);
    std::array<Vector3d, 8> centres;
    std::vector<Vector3d> witnesses = cell.witnesses;
    for (std::size_t k = 0; k < 8; ++k) {
      centres[k] = cell.centre + 0.5 * cell.half * Vector3d(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
      for (const Vector3d& witness : witnesses_.near(centres[k])) witnesses.push_back(witness);
    }
    const auto part = [&](std::size_t k) { divide(partOf(cell, centres[k], witnesses)); };
    if (cell.maybe.size() > kParallelCell)
      tbb::parallel_for(std::size_t{0}, std::size_t{8}, part);
    else
      for (std::size_t k = 0; k < 8; ++k) part(k);
  }

  /// Small compared with the disc in which the largest ball about the centre cuts a face: its radius is about
  /// sqrt(2 r overhang).
  bool isSmall(const Cell& cell) const {
    return !cell.witnesses.empty() && cell.half < kSmallestCell * std::sqrt(2 * (cell.witnesses.front() - cell.centre).norm() * overhang_);
  }

  /// Keeps the points that a ball may hold. A ball about c without the witness e holds y only if |c - y| < |c - e|,
  /// which is linear in c, so that the corner of the cube that favours y most decides.
  Cell partOf(const Cell& whole, const Vector3d& centre, const std::vector<Vector3d>& witnesses) const {
    Cell part;
    part.centre = centre, part.half = 0.5 * whole.half;
    part.sure = whole.sure, part.sure_weight = whole.sure_weight;
    part.witnesses = chosenWitnesses(centre, part.half, witnesses);
    std::array<Vector3d, kWitnesses> to;
    std::array<double, kWitnesses> to2;
    const std::size_t count = part.witnesses.size();
    for (std::size_t k = 0; k < count; ++k) to[k] = part.witnesses[k] - centre, to2[k] = to[k].squaredNorm();
    for (const std::uint32_t i : whole.maybe) {
      const Vector3d y = points_[i] - centre;
      const double y2 = y.squaredNorm(), slack = 16 * rounding_ * (std::sqrt(y2) + part.half + rounding_);
      bool possible = true, sure = count > 0;
      for (std::size_t k = 0; k < count && possible; ++k) {
        const double excess = y2 - to2[k], reach = 2 * part.half * (to[k] - y).lpNorm<1>();
        possible = !(excess > reach + slack);
        sure = sure && excess < -reach;
      }
      if (!possible) continue;
      (sure ? part.sure : part.maybe).push_back(i);
      (sure ? part.sure_weight : part.maybe_weight) += weight_[i];
    }
    return part;
  }

  /// Of the witnesses that may be nearest to a point of the cube: the nearest, then always the one farthest from those
  /// chosen.
  std::vector<Vector3d> chosenWitnesses(const Vector3d& centre, double half, const std::vector<Vector3d>& witnesses) const {
    std::vector<Vector3d> near, chosen;
    if (witnesses.empty()) return chosen;
    const auto distance2 = [&](const Vector3d& e) { return (e - centre).squaredNorm(); };
    Vector3d next = *std::min_element(witnesses.begin(), witnesses.end(),
                                      [&](const Vector3d& a, const Vector3d& b) { return distance2(a) < distance2(b); });
    const double reach = std::sqrt(distance2(next)) + 2 * std::sqrt(3.0) * half;
    for (const Vector3d& e : witnesses)
      if (distance2(e) <= reach * reach) near.push_back(e);
    std::vector<double> apart2(near.size(), std::numeric_limits<double>::infinity());
    while (chosen.size() < kWitnesses) {
      chosen.push_back(next);
      for (std::size_t i = 0; i < near.size(); ++i) apart2[i] = std::min(apart2[i], (near[i] - next).squaredNorm());
      const auto farthest = std::max_element(apart2.begin(), apart2.end());
      if (!(*farthest > 0)) break;
      next = near[static_cast<std::size_t>(farthest - apart2.begin())];
    }
    return chosen;
  }

  void lower(const Cell& cell, double factor) {
    for (const std::vector<std::uint32_t>* list : {&cell.sure, &cell.maybe})
      for (const std::uint32_t i : *list) {  // a minimum is independent of the order of the threads
        std::atomic_ref<double> share(share_[i]);
        double old = share.load(std::memory_order_relaxed);
        while (old > factor && !share.compare_exchange_weak(old, factor, std::memory_order_relaxed)) {
        }
      }
  }

  const DistanceField& field_;
  const WitnessIndex& witnesses_;
  const SampleIndex& points_;
  const std::vector<double>& weight_;
  double overhang_, rounding_;
  const Progress& progress_;
  std::vector<double> share_;
};

SampleIndex pointsOf(const TriangleMesh& surface, std::size_t spheres, std::uint64_t seed) {
  if (spheres == 0) throw std::invalid_argument("lower bound: no spheres");
  const std::size_t count = std::clamp(kPointsASphere * spheres, kMinBoundPoints, kMaxBoundPoints);
  std::vector<Vector3d> points;
  for (const SurfacePoint& sample : spreadOverSurface(surface, count, seed)) points.push_back(sample.point);
  if (points.empty()) throw std::invalid_argument("lower bound: the surface has no area");
  return SampleIndex(points);
}

/// The points held by each ball, and the balls that hold each point: rows of a sparse matrix of ones.
struct Incidence {
  std::vector<std::uint32_t> first, item;

  Incidence transposed(std::size_t items) const {
    Incidence out;
    out.first.assign(items + 1, 0);
    for (const std::uint32_t i : item) ++out.first[i + 1];
    for (std::size_t i = 0; i < items; ++i) out.first[i + 1] += out.first[i];
    out.item.resize(item.size());
    std::vector<std::uint32_t> next(out.first.begin(), out.first.end() - 1);
    for (std::uint32_t row = 0; row + 1 < first.size(); ++row)
      for (std::uint32_t k = first[row]; k < first[row + 1]; ++k) out.item[next[item[k]]++] = row;
    return out;
  }
  void sums(const std::vector<double>& of, std::vector<double>& out) const {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, first.size() - 1, 256), [&](const tbb::blocked_range<std::size_t>& range) {
      for (std::size_t row = range.begin(); row < range.end(); ++row) {
        double sum = 0;
        for (std::uint32_t k = first[row]; k < first[row + 1]; ++k) sum += of[item[k]];
        out[row] = sum;
      }
    });
  }
};

}  // namespace

LowerBound::LowerBound(const TriangleMesh& surface, const DistanceField& field, std::size_t spheres, std::uint64_t seed, Progress& progress)
    : field_(field), points_(pointsOf(surface, spheres, seed)) {
  count_ = std::clamp(kPointsASphere * spheres, kMinBoundPoints, kMaxBoundPoints);
  const std::vector<SurfacePoint> touched =
      spreadOverSurface(surface, std::clamp(kMedialASphere * spheres, kMinBoundPoints / 4, count_), ~seed);
  medial_.resize(touched.size());
  const double noise_angle = CoverLimitSettings{}.noise_angle;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, touched.size(), 64), [&](const tbb::blocked_range<std::size_t>& range) {
    if (progress.cancelled()) return;
    for (std::size_t i = range.begin(); i < range.end(); ++i)
      medial_[i] = largestInnerBall(field, touched[i].point, touched[i].triangle, noise_angle).centre;
  });
  progress.check();
}

std::vector<double> LowerBound::balancedWeights(const WitnessIndex& witnesses, double overhang, Progress& progress) const {
  std::vector<std::vector<std::uint32_t>> held(medial_.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, medial_.size(), 64), [&](const tbb::blocked_range<std::size_t>& range) {
    if (progress.cancelled()) return;
    for (std::size_t b = range.begin(); b < range.end(); ++b) {
      double radius = kInfinity;
      for (const Vector3d& witness : witnesses.near(medial_[b])) radius = std::min(radius, (witness - medial_[b]).norm());
      if (radius == kInfinity) continue;
      points_.within(medial_[b], radius + kGuard * overhang,
                     [&](std::size_t slot, double) { held[b].push_back(static_cast<std::uint32_t>(slot)); });
    }
  });
  progress.check();
  Incidence balls{{0}, {}};
  for (const std::vector<std::uint32_t>& list : held) {
    balls.item.insert(balls.item.end(), list.begin(), list.end());
    balls.first.push_back(static_cast<std::uint32_t>(balls.item.size()));
  }
  held = {};
  const Incidence holders = balls.transposed(count_);
  // Start: 1 / (number of points in the fullest ball that holds the point); nothing is known of a point in no ball.
  std::vector<double> weight(count_, 1.0), full(medial_.size()), push(count_);
  balls.sums(weight, full);
  for (std::size_t i = 0; i < count_; ++i) {
    double fullest = 0;
    for (std::uint32_t k = holders.first[i]; k < holders.first[i + 1]; ++k) fullest = std::max(fullest, full[holders.item[k]]);
    weight[i] = fullest > 0 ? 1 / fullest : 0;
  }
  // Raises weights of points whose balls are not full, and lowers the others: the dual of the fractional cover.
  for (int round = 0; round < kBalanceRounds; ++round) {
    progress.check();
    const double softness = kFirstSoftness * std::pow(kLastSoftness / kFirstSoftness, static_cast<double>(round) / kBalanceRounds);
    balls.sums(weight, full);
    for (double& ball : full) ball = std::exp(std::min(20.0, (ball - 1) / softness));
    holders.sums(full, push);
    for (std::size_t i = 0; i < count_; ++i) weight[i] *= std::exp(-softness * std::clamp(push[i] - 1, -1.0, 1.0));
  }
  balls.sums(weight, full);
  const double fullest = *std::max_element(full.begin(), full.end());
  for (double& w : weight) w /= std::max(fullest, 1e-300);
  return weight;
}

LowerBound::Weights LowerBound::weights(double overhang, Progress& progress) const {
  Weights out;
  const WitnessIndex witnesses(field_, points_, overhang);
  out.weight = balancedWeights(witnesses, overhang, progress);
  BallWeights balls(field_, witnesses, points_, out.weight, overhang, progress);
  const std::vector<double>& share = balls.prove();
  for (std::size_t i = 0; i < count_; ++i) {
    out.weight[i] *= share[i] * (1 - 1e-9) / kFullBall;
    out.total += out.weight[i];
  }
  out.total *= 1 - 1e-9;
  return out;
}

double LowerBound::spheresNeeded(double overhang, Progress& progress) const { return weights(overhang, progress).total; }

ProvenLimit provenLimit(const LowerBound& bound, std::size_t spheres, double upper, Progress& progress) {
  constexpr int kTries = 5;
  ProvenLimit out;
  const double wanted = static_cast<double>(spheres) * (1 + 1e-9);
  double overhang = 0.6 * upper, power = 1, last_overhang = 0, last_needed = 0;  // the number is about overhang^-power
  for (int attempt = 0; attempt < kTries && overhang > 0; ++attempt) {
    const double needed = bound.spheresNeeded(overhang, progress);
    const bool proven = needed > wanted;
    if (proven && overhang > out.overhang) out.overhang = overhang, out.spheres = needed;
    if (proven && needed < 1.015 * wanted) break;
    if (last_needed > 0 && overhang != last_overhang)
      power = std::clamp(std::log(last_needed / needed) / std::log(overhang / last_overhang), 0.2, 2.0);
    last_overhang = overhang, last_needed = needed;
    overhang *= std::clamp(std::pow(needed / (1.007 * wanted), 1 / power), 0.25, 1.6);
    progress.advance(static_cast<double>(attempt + 1) / kTries);
  }
  return out;
}

}  // namespace spheretree::builder
