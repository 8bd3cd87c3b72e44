// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/distance_grid.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace spheretree::player {
namespace {

constexpr int kPadding = 2;  // cells

/// Weights of the four points around a position `t` in [0, 1] of the middle cell, and their derivatives by t.
struct Spline {
  std::array<double, 4> weight, slope;
  explicit Spline(double t)
      : weight{((2 - t) * t - 1) * t / 2, ((3 * t - 5) * t * t + 2) / 2, ((4 - 3 * t) * t + 1) * t / 2, (t - 1) * t * t / 2},
        slope{((-3 * t + 4) * t - 1) / 2, (9 * t - 10) * t / 2, ((-9 * t + 8) * t + 1) / 2, (3 * t - 2) * t / 2} {}
};

}  // namespace

DistanceGrid::DistanceGrid(const builder::DistanceField& field, std::size_t bytes) {
  const Eigen::Vector3d size = field.box().sizes();
  const auto points = static_cast<double>(std::max<std::size_t>(bytes / sizeof(float), 512));
  cell_ = std::cbrt(std::max(size.prod(), 1e-9) / points);
  const auto countsOf = [&] {
    double product = 1;
    for (std::size_t k = 0; k < 3; ++k) {
      count_[k] = std::max(8, static_cast<int>(std::ceil(size[static_cast<Eigen::Index>(k)] / cell_)) + 1 + 2 * kPadding);
      product *= count_[k];
    }
    return product;
  };
  while (countsOf() > points && cell_ < size.maxCoeff()) cell_ *= 1.02;
  for (Eigen::Index k = 0; k < 3; ++k) {  // centres the body
    const double length = cell_ * (count_[static_cast<std::size_t>(k)] - 1);
    box_.min()[k] = field.box().center()[k] - length / 2;
    box_.max()[k] = field.box().center()[k] + length / 2;
  }
  const auto nx = static_cast<std::size_t>(count_[0]), ny = static_cast<std::size_t>(count_[1]), nz = static_cast<std::size_t>(count_[2]);
  values_.resize(nx * ny * nz);
  tbb::parallel_for(std::size_t{0}, ny * nz, [&](std::size_t row) {
    for (std::size_t x = 0; x < nx; ++x) {
      const Eigen::Vector3d p =
          box_.min() + cell_ * Eigen::Vector3d(static_cast<double>(x), static_cast<double>(row % ny), static_cast<double>(row / ny));
      values_[row * nx + x] = static_cast<float>(field.signedDistance(p));
    }
  });
}

DistanceGrid::Sample DistanceGrid::at(const Eigen::Vector3d& p) const {
  if (!box_.contains(p)) {
    const Eigen::Vector3d away = p - p.cwiseMax(box_.min()).cwiseMin(box_.max());
    return {away.norm() + (kPadding - 1) * cell_, away.normalized()};
  }
  std::array<int, 3> first{};
  std::array<Spline, 3> axis{Spline(0), Spline(0), Spline(0)};
  for (std::size_t k = 0; k < 3; ++k) {
    const double u = (p[static_cast<Eigen::Index>(k)] - box_.min()[static_cast<Eigen::Index>(k)]) / cell_;
    const int cell = std::clamp(static_cast<int>(u), 0, count_[k] - 2);
    first[k] = cell - 1;
    axis[k] = Spline(u - cell);
  }
  const auto inside = [&](int i, std::size_t k) { return std::clamp(i, 0, count_[k] - 1); };
  Sample out{0, Eigen::Vector3d::Zero()};
  for (int z = 0; z < 4; ++z)
    for (int y = 0; y < 4; ++y) {
      double along = 0, slope = 0;
      for (int x = 0; x < 4; ++x) {
        const auto v = static_cast<double>(value(inside(first[0] + x, 0), inside(first[1] + y, 1), inside(first[2] + z, 2)));
        along += axis[0].weight[static_cast<std::size_t>(x)] * v;
        slope += axis[0].slope[static_cast<std::size_t>(x)] * v;
      }
      const auto iy = static_cast<std::size_t>(y), iz = static_cast<std::size_t>(z);
      out.distance += axis[1].weight[iy] * axis[2].weight[iz] * along;
      out.gradient += Eigen::Vector3d(axis[1].weight[iy] * axis[2].weight[iz] * slope, axis[1].slope[iy] * axis[2].weight[iz] * along,
                                      axis[1].weight[iy] * axis[2].slope[iz] * along) /
                      cell_;
    }
  return out;
}

}  // namespace spheretree::player
