// SPDX-License-Identifier: GPL-3.0-or-later
#include "measure/cover_limits.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "geometry/box_tree.h"
#include "measure/coverage.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kDiscs = 2;  // number of discs in which one ball intersects the surface

/// Solves balls * discs * pi * h = 1.2092 * area * mean of 1 / (2 r + h).
double finiteLimit(const std::vector<Ball>& medial, double area, double balls) {
  double low = 0, high = std::sqrt(kHexagonalCover * area / (balls * kDiscs * std::numbers::pi));  // the solution if all r = 0
  for (int step = 0; step < 60; ++step) {
    const double h = 0.5 * (low + high);
    double mean = 0;
    for (const Ball& ball : medial) mean += 1 / (2 * ball.radius + h);
    mean /= static_cast<double>(medial.size());
    (balls * kDiscs * std::numbers::pi * h < kHexagonalCover * area * mean ? low : high) = h;
  }
  return 0.5 * (low + high);
}

/// Lower limit of the number of balls with overhang h: the sum over the samples y of 1 / a(y), with a(y) the number of
/// samples in the fullest admissible ball that contains y.
class BallCount {
 public:
  BallCount(const std::vector<SurfacePoint>& samples, const std::vector<Ball>& inscribed) : inscribed_(inscribed) {
    std::vector<Eigen::AlignedBox3d> boxes;
    for (const SurfacePoint& sample : samples) boxes.emplace_back(sample.point, sample.point);
    tree_ = BoxTree(boxes, 8);
    for (const std::uint32_t i : tree_.order()) points_.push_back(samples[i].point);
    fullest_.resize(points_.size());
  }

  double atLeast(double h, const Progress& progress) {
    std::fill(fullest_.begin(), fullest_.end(), 0u);
    const std::size_t stride = strideFor(h);
    std::atomic<std::uint32_t> largest{0};
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, (inscribed_.size() + stride - 1) / stride, 32),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                        if (progress.cancelled()) return;
                        std::vector<std::uint32_t> held;
                        for (std::size_t k = range.begin(); k < range.end(); ++k) {
                          pointsIn(inscribed_[k * stride], h, held);
                          const auto count = static_cast<std::uint32_t>(held.size());
                          raise(largest, count);
                          // A maximum is independent of the order of the threads.
                          for (const std::uint32_t i : held) {
                            std::atomic_ref<std::uint32_t> fullest(fullest_[i]);
                            raise(fullest, count);
                          }
                        }
                      });
    progress.check();
    double sum = 0;
    for (const std::uint32_t fullest : fullest_) sum += 1.0 / std::max(1u, fullest > 0 ? fullest : largest.load());
    return sum;
  }

 private:
  template <class Atomic>
  static void raise(Atomic& atomic, std::uint32_t value) {
    std::uint32_t old = atomic.load(std::memory_order_relaxed);
    while (old < value && !atomic.compare_exchange_weak(old, value, std::memory_order_relaxed)) {
    }
  }

  void pointsIn(const Ball& inscribed, double h, std::vector<std::uint32_t>& held) const {
    held.clear();
    const double r2 = (inscribed.radius + h) * (inscribed.radius + h);
    tree_.searchWithin(inscribed.centre, r2, [&](std::size_t first, std::size_t count) {
      for (std::size_t i = first; i < first + count; ++i)
        if ((points_[i] - inscribed.centre).squaredNorm() <= r2) held.push_back(static_cast<std::uint32_t>(i));
    });
  }

  /// If every ball contains most of the surface (as for a sphere), the balls are alike, and a subset of them suffices.
  std::size_t strideFor(double h) const {
    constexpr std::size_t kProbe = 64, kMax = 20'000'000;
    std::vector<std::uint32_t> held;
    std::size_t held_sum = 0;
    for (std::size_t i = 0; i < inscribed_.size(); i += kProbe) {
      pointsIn(inscribed_[i], h, held);
      held_sum += kProbe * held.size();
    }
    return 1 + held_sum / kMax;
  }

  const std::vector<Ball>& inscribed_;
  BoxTree tree_;
  std::vector<Vector3d> points_;        // in slot order
  std::vector<std::uint32_t> fullest_;  // a(y)
};

}  // namespace

Ball largestInnerBall(const DistanceField& field, const Vector3d& p, std::uint32_t triangle, double noise_angle) {
  const Vector3d inward = -field.normal(triangle);
  const double smallest = 1e-9 * field.diagonal(), max_cosine = std::cos(noise_angle);
  double radius = field.diagonal();
  for (int step = 0; step < 100 && radius > smallest; ++step) {
    const Vector3d centre = p + radius * inward;
    // The ball is empty up to a thousandth of its radius: done, unless the solid is thinner than that and the centre
    // outside.
    NearestPoint contact = field.nearest(centre, radius * (1 - 1e-3));
    if (!std::isfinite(contact.distance) && field.signedDistance(centre, &contact) < 0) break;
    // The ball through p and the contact that touches the surface at p.
    const Vector3d chord = contact.point - p;
    const double depth = chord.dot(inward);
    if (!(depth > 0)) break;
    const double smaller = chord.squaredNorm() / (2 * depth);
    if (!(smaller < radius)) break;
    const Vector3d to_contact = contact.point - (p + smaller * inward);
    // The contact is beside p and has the same orientation: it is roughness, not the other side of a thin curved wire
    // or sheet.
    const bool is_beside = -inward.dot(to_contact) > max_cosine * to_contact.norm();
    if (is_beside && field.normal(contact.triangle).dot(inward) < 0) break;
    radius = smaller;
  }
  return {p + radius * inward, radius};
}

CoverLimits coverLimits(const TriangleMesh& mesh, const DistanceField& field, std::size_t balls, const CoverLimitSettings& settings,
                        Progress& progress) {
  if (balls == 0 || settings.candidates == 0 || settings.samples < settings.candidates)
    throw std::invalid_argument("cover limits: settings out of range");
  const std::vector<SurfacePoint> samples = spreadOverSurface(mesh, settings.samples, settings.seed);
  if (samples.empty()) throw std::invalid_argument("cover limits: the mesh has no area");
  std::vector<Ball> medial(samples.size()), inscribed(settings.candidates);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, medial.size(), 64), [&](const tbb::blocked_range<std::size_t>& range) {
    if (progress.cancelled()) return;
    for (std::size_t i = range.begin(); i < range.end(); ++i)
      medial[i] = largestInnerBall(field, samples[i].point, samples[i].triangle, settings.noise_angle);
  });
  progress.check();
  CoverLimits out;
  out.h_fin = finiteLimit(medial, field.area(), static_cast<double>(balls));

  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, inscribed.size(), 64), [&](const tbb::blocked_range<std::size_t>& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const Vector3d& centre = medial[i * medial.size() / inscribed.size()].centre;
      inscribed[i] = {centre, -field.signedDistance(centre)};
    }
  });
  std::erase_if(inscribed, [](const Ball& ball) { return !(ball.radius > 0); });
  // Patches of at least 16 samples; for more balls, h is extrapolated as 1 / n.
  const double wanted = std::min(static_cast<double>(balls), static_cast<double>(samples.size()) / 16);
  double low = std::log(5e-5 * field.diagonal()), high = std::log(0.3 * field.diagonal());
  BallCount needed(samples, inscribed);
  const auto surplus = [&](double log_h) { return std::log(needed.atLeast(std::exp(log_h), progress) / wanted); };
  // False position in log-log coordinates, where the curve is nearly straight, from a guess: the limit is usually a
  // third of h_fin.
  double h = std::clamp(std::log(out.h_fin / 3), low, high), at_low = 0, at_high = 0;
  bool known_low = false, known_high = false, found = false;
  for (int step = 0; step < 40 && high - low > 4e-3; ++step) {
    const double at_h = surplus(h);
    if (at_h > 0) {
      low = h, at_low = at_h, known_low = true;
    } else {
      high = h, at_high = at_h, known_high = true;
    }
    found = std::abs(at_h) < 3e-3;
    if (found) break;
    if (known_low && known_high) {
      const double share = step % 2 ? 0.5 : std::clamp(at_low / (at_low - at_high), 0.1, 0.9);
      h = low + share * (high - low);
    } else {
      h = known_low ? std::min(high, h + 0.4) : std::max(low, h - 0.4);
    }
  }
  if (!found && known_low && known_high) h = at_low < -at_high ? low : high, found = true;
  out.h_low_in_range = found;
  if (found || known_low) out.h_low = std::exp(found ? h : high) * wanted / static_cast<double>(balls);
  return out;
}

}  // namespace spheretree::builder
