// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/batch/error_curve.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace spheretree::pipeline {
namespace {

// Exponents of the error as a power of the leaves, outside the measured range: a surface has 1, a rod 2 as long as its
// leaves are in a row.
constexpr double kSteepest = 2, kFlattest = 0.5, kUsual = 1;
constexpr double kClose = 0.02;  // logarithm of a ratio of leaves: two points this close do not determine a slope

/// The smallest number of leaves with at most this error, or `max_count`.
std::size_t leavesFor(const ErrorCurve& curve, double error, std::size_t max_count) {
  std::size_t low = 0, high = max_count;  // `low` is too small
  while (high - low > 1) {
    const std::size_t middle = low + (high - low) / 2;
    (curve.errorAt(static_cast<double>(middle)) <= error ? high : low) = middle;
  }
  return high;
}

}  // namespace

void ErrorCurve::add(double leaves, double error) {
  const Point p{std::log(leaves), std::log(error)};
  std::erase_if(points_,
                [&](const Point& q) { return std::abs(q.leaves - p.leaves) < kClose || (q.leaves > p.leaves && q.error >= p.error); });
  const auto at = std::find_if(points_.begin(), points_.end(), [&](const Point& q) { return q.leaves > p.leaves; });
  if (at != points_.begin() && std::prev(at)->error <= p.error) return;
  points_.insert(at, p);
}

void ErrorCurve::moveTo(double leaves, double error) {
  if (!points_.empty()) {
    const double by = std::log(error) - std::log(errorAt(leaves));
    for (Point& p : points_) p.error += by;
  }
  add(leaves, error);
}

double ErrorCurve::errorAt(double leaves) const {
  const double x = std::log(leaves);
  if (points_.empty()) return std::exp(-kUsual * x);
  const auto right = std::find_if(points_.begin(), points_.end(), [&](const Point& q) { return q.leaves >= x; });
  if (right != points_.begin() && right != points_.end()) {
    const Point &a = *std::prev(right), &b = *right;
    return std::exp(a.error + (x - a.leaves) / (b.leaves - a.leaves) * (b.error - a.error));
  }
  double power = kUsual;
  if (points_.size() >= 2) {
    const Point& a = right == points_.end() ? points_[points_.size() - 2] : points_[0];
    const Point& b = right == points_.end() ? points_.back() : points_[1];
    power = std::clamp((a.error - b.error) / (b.leaves - a.leaves), kFlattest, kSteepest);
  }
  const Point& end = right == points_.end() ? points_.back() : points_.front();
  return std::exp(end.error - power * (x - end.leaves));
}

LeafShares shareLeaves(std::span<const ErrorCurve> curves, std::span<const std::size_t> max_leaves, std::size_t total) {
  const auto sharesOf = [&](double error) {
    LeafShares out{{}, error};
    for (std::size_t i = 0; i < curves.size(); ++i) out.leaves.push_back(leavesFor(curves[i], error, max_leaves[i]));
    return out;
  };
  const auto fits = [&](const LeafShares& shares) {
    return std::accumulate(shares.leaves.begin(), shares.leaves.end(), std::size_t{0}) <= total;
  };
  double low = 0, high = 1e-300;  // logarithms from here on
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const double coarsest = curves[i].errorAt(1), finest = curves[i].errorAt(static_cast<double>(max_leaves[i]));
    low = i == 0 ? finest : std::min(low, finest);
    high = std::max(high, coarsest);
  }
  low = std::log(low), high = std::log(high) + 1e-9;  // high: one leaf for each
  if (LeafShares all = sharesOf(std::exp(low)); fits(all)) return all;
  for (int step = 0; step < 60; ++step) {
    const double middle = (low + high) / 2;
    (fits(sharesOf(std::exp(middle))) ? high : low) = middle;
  }
  return sharesOf(std::exp(high));
}

}  // namespace spheretree::pipeline
