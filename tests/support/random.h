// SPDX-License-Identifier: Apache-2.0
// Seeded random numbers that are the same with every standard library.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace spheretree::test {

/// SplitMix64 (Steele, Lea, Flood 2014). The distributions of the standard library differ between implementations;
/// these do not.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  std::uint64_t below(std::uint64_t limit) { return next() % limit; }
  double unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }            // in [0, 1)
  double between(double low, double high) { return low + (high - low) * unit(); }  // in [low, high)
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
  std::uint64_t state_;
};

}  // namespace spheretree::test
