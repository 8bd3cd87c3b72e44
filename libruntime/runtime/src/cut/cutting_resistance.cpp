// SPDX-License-Identifier: Apache-2.0
#include "cut/cutting_resistance.h"

#include <algorithm>
#include <cmath>

namespace spheretree::runtime {
namespace {

constexpr int kMaxIterations = 40;  // of Newton's method, each with a smaller cost; the facets that count settle in 3 to 6
constexpr int kMaxHalvings = 30;
constexpr double kSettled = 1e-9;       // [mm, scaled]
constexpr int kCorrections = 4;         // of the rate, which end when
constexpr double kSettledShare = 1e-3;  // it changes by less than this share: the volume is then within it of K F T

using Matrix6 = Eigen::Matrix<double, 6, 6, Eigen::DontAlign>;

[[gnu::always_inline]] inline double depthOf(const CutFacet& facet, const Vector6& y) { return facet.along.dot(y) - facet.gap; }

// The equations are I + positive semidefinite, so that Cholesky's method needs no pivots.
Vector6 solved(Matrix6 m, Vector6 right) {
  for (int k = 0; k < 6; ++k) {
    for (int j = 0; j < k; ++j) m(k, k) -= m(k, j) * m(k, j);
    m(k, k) = std::sqrt(m(k, k));
    for (int i = k + 1; i < 6; ++i) {
      for (int j = 0; j < k; ++j) m(i, k) -= m(i, j) * m(k, j);
      m(i, k) /= m(k, k);
    }
    for (int j = 0; j < k; ++j) right[k] -= m(k, j) * right[j];
    right[k] /= m(k, k);
  }
  for (int k = 5; k >= 0; --k) {
    for (int j = k + 1; j < 6; ++j) right[k] -= m(j, k) * right[j];
    right[k] /= m(k, k);
  }
  return right;
}

// The problem with the rates times `share`.
class Problem {
 public:
  Problem(std::span<const CutFacet> facets, const Vector6& target, double per_rate)
      : facets_(facets), target_(target), per_rate_(per_rate) {}

  void correct(double share) { share_ = share; }

  Vector6 minimum(Vector6 y) const {
    double cost = costAt(y);
    for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
      const Vector6 step = newtonStep(y);
      double length = 1, next = costAt(y + step);
      for (int halving = 0; next > cost && halving < kMaxHalvings; ++halving) next = costAt(y + (length /= 2) * step);
      if (next > cost) break;
      y += length * step;
      cost = next;
      if (step.norm() < kSettled) break;
    }
    return y;
  }

 private:
  double weightOf(const CutFacet& facet) const { return facet.area / (facet.rate * share_) * per_rate_; }

  double costAt(const Vector6& y) const {
    double cost = 0.5 * (y - target_).squaredNorm();
    for (const CutFacet& facet : facets_)
      if (const double depth = depthOf(facet, y); depth > 0) cost += 0.5 * weightOf(facet) * depth * depth;
    return cost;
  }

  Vector6 newtonStep(const Vector6& y) const {
    Matrix6 matrix = Matrix6::Identity();
    Vector6 slope = y - target_;
    for (const CutFacet& facet : facets_) {
      const double depth = depthOf(facet, y);
      if (!(depth > 0)) continue;
      const double weight = weightOf(facet);
      slope += weight * depth * facet.along;
      for (int i = 0; i < 6; ++i)
        for (int j = 0; j <= i; ++j) matrix(i, j) += weight * facet.along[i] * facet.along[j];
    }
    return solved(matrix, -slope);
  }

  std::span<const CutFacet> facets_;
  const Vector6& target_;
  double per_rate_;  // 1 / (stiffness * time)
  double share_ = 1;
};

}  // namespace

CutStep cutStep(std::span<const CutFacet> facets, const Vector6& target, const CutStep& guess, double stiffness, double time) noexcept {
  Problem problem(facets, target, 1 / (stiffness * time));
  CutStep out = guess;
  double& share = out.rate_share;
  problem.correct(share);
  for (int round = 0;; ++round) {
    out.y = problem.minimum(out.y);
    double wanted = 0;                              // the force by Preston's law, times the time
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();  // the same of the facets, with the rates as they are
    out.volume = 0;
    for (const CutFacet& facet : facets) {
      const double depth = depthOf(facet, out.y);
      if (!(depth > 0)) continue;
      out.volume += facet.area * depth;
      wanted += facet.area * depth / facet.rate;
      sum += facet.area * depth / facet.rate * facet.direction;
    }
    out.force = -1 / (share * time) * sum;
    const double next = wanted > 0 ? std::max(sum.norm() / wanted, 1e-3) : share;
    if (round == kCorrections || std::abs(next - share) < kSettledShare * share) return out;
    share = next;
    problem.correct(share);
  }
}

}  // namespace spheretree::runtime
