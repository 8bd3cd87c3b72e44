// SPDX-License-Identifier: Apache-2.0
// Seeded random numbers that are the same with every standard library.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <random>

namespace spheretree::test {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }  // in [0, 1)
  double between(double low, double high) { return low + (high - low) * unit(); }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(engine_() % n); }
  Eigen::Vector3d inBox(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
    const double x = unit(), y = unit(), z = unit();
    return low + (high - low).cwiseProduct(Eigen::Vector3d(x, y, z));
  }
  Eigen::Vector3d inCube(double half) { return inBox(Eigen::Vector3d::Constant(-half), Eigen::Vector3d::Constant(half)); }
  Eigen::Vector3d direction() {
    while (true) {
      const Eigen::Vector3d p = inCube(1);
      if (const double length = p.norm(); length > 0.01 && length < 1) return p / length;
    }
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace spheretree::test
