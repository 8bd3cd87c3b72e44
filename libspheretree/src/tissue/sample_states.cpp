// SPDX-License-Identifier: GPL-3.0-or-later
#include "tissue/sample_states.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/random.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kSqueeze = 0.3, kPokeMm = 5, kBend = std::numbers::pi / 3, kNoise = 0.2, kInverted = 1.5;  // largest amounts

class States {
 public:
  States(const Tissue& tissue, std::uint64_t seed) : tissue_(tissue), random_(seed) {
    for (const auto& p : tissue.nodes) nodes_.emplace_back(p[0], p[1], p[2]), box_.extend(nodes_.back());
  }

  TissueState make(std::size_t kind, double share) {
    switch (kind) {
      case 0:
        return squeeze(kSqueeze * share);
      case 1:
        return poke(kPokeMm * share);
      case 2:
        return bend(kBend * share);
      case 3:
        return noise("noise", kNoise * share);
      default:
        return noise("inverted", kInverted * share);
    }
  }

 private:
  double unit() { return randomUnit(random_); }
  Vector3d direction() {
    while (true) {
      const double x = 2 * unit() - 1, y = 2 * unit() - 1, z = 2 * unit() - 1;
      const Vector3d p(x, y, z);
      if (const double length = p.norm(); length > 0.01 && length < 1) return p / length;
    }
  }

  template <class Map>
  TissueState mapped(const char* kind, double amount, Map map) const {
    TissueState state{kind, amount, {}};
    for (const Vector3d& p : nodes_) state.displacements.push_back(map(p) - p);
    return state;
  }

  TissueState squeeze(double share) {
    const Vector3d axis = direction(), middle = box_.center();
    const double along = 1 - share, across = 1 / std::sqrt(along);
    return mapped("squeeze", share, [&](const Vector3d& p) {
      const Vector3d from = p - middle, part = axis.dot(from) * axis;
      return Vector3d(middle + along * part + across * (from - part));
    });
  }

  TissueState poke(double depth) {
    const TissueVertex& at = tissue_.surface[random_() % tissue_.surface.size()];
    const Vector3d tip(at.rest[0], at.rest[1], at.rest[2]), inward = (box_.center() - tip).normalized();
    const double width = std::max(depth, 0.05 * box_.diagonal().norm());
    return mapped("poke", depth, [&](const Vector3d& p) {
      return Vector3d(p + depth * std::exp(-(p - tip).squaredNorm() / (2 * width * width)) * inward);
    });
  }

  // The middle line along the longest side becomes an arc; cross-sections stay plane.
  TissueState bend(double angle) {
    Eigen::Index longest = 0;
    const double length = box_.sizes().maxCoeff(&longest);
    const Vector3d along = Vector3d::Unit(longest);
    const double turn = 2 * std::numbers::pi * unit();
    const Vector3d across = std::cos(turn) * Vector3d::Unit((longest + 1) % 3) + std::sin(turn) * Vector3d::Unit((longest + 2) % 3);
    const Vector3d axis = along.cross(across), middle = box_.center();
    return mapped("bend", angle, [&](const Vector3d& p) {
      const Vector3d from = p - middle;
      const double theta = angle * along.dot(from) / length, radius = length / std::max(angle, 1e-9) - across.dot(from);
      const double arc = length / std::max(angle, 1e-9);
      return Vector3d(middle + axis.dot(from) * axis + radius * std::sin(theta) * along + (arc - radius * std::cos(theta)) * across);
    });
  }

  TissueState noise(const char* kind, double share) {
    double sum = 0;
    for (const auto& c : tissue_.tetrahedra) sum += (nodes_[c[0]] - nodes_[c[1]]).norm();
    const double largest = share * sum / static_cast<double>(tissue_.tetrahedra.size());
    return mapped(kind, share, [&](const Vector3d& p) {
      const Vector3d to = direction();
      return Vector3d(p + largest * unit() * to);
    });
  }

  const Tissue& tissue_;
  std::mt19937_64 random_;
  std::vector<Vector3d> nodes_;
  Eigen::AlignedBox3d box_;
};

}  // namespace

TissueState sampleState(const Tissue& tissue, std::size_t index, std::size_t count, std::uint64_t seed) {
  constexpr std::size_t kKinds = 5;
  const std::size_t rounds = std::max<std::size_t>(1, (count + kKinds - 1) / kKinds), round = index / kKinds;
  return States(tissue, seed + 0x9e3779b97f4a7c15u * (index + 1))
      .make(index % kKinds, static_cast<double>(round + 1) / static_cast<double>(rounds));
}

StateStrain strainOf(const Tissue& tissue, std::span<const Vector3d> displacements) {
  StateStrain strain;
  if (!tissue.tetrahedra.empty()) strain = {0, std::numeric_limits<double>::infinity(), 0};
  for (const auto& c : tissue.tetrahedra) {
    Eigen::Matrix3d rest, moved;
    const auto at = [&](std::uint32_t node) { return Vector3d(tissue.nodes[node][0], tissue.nodes[node][1], tissue.nodes[node][2]); };
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t node = c[static_cast<std::size_t>(k) + 1];
      rest.col(k) = at(node) - at(c[0]);
      moved.col(k) = rest.col(k) + displacements[node] - displacements[c[0]];
    }
    const Eigen::Matrix3d gradient = moved * rest.inverse();
    const Eigen::Vector3d stretch = Eigen::JacobiSVD<Eigen::Matrix3d>(gradient).singularValues();
    strain.largest_stretch = std::max(strain.largest_stretch, stretch[0]);
    strain.smallest_stretch = std::min(strain.smallest_stretch, stretch[2]);
    strain.inverted += gradient.determinant() <= 0;
  }
  return strain;
}

}  // namespace spheretree::builder
