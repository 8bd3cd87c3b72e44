// SPDX-License-Identifier: GPL-3.0-or-later
// A cube that is cut by half-spaces, and its volume.
// Units: mm.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace spheretree::builder {

/// The points with normal . (p - centre of the cube) + offset <= 0. The normal may be any vector, also zero.
struct HalfSpace {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double offset = 0;
};

/// Points are stored relative to the centre of the cube. No point of a cut lies outside of the cube, since it is
/// between two corners; the error of a volume is therefore below 1e-11 of that of the cube.
class ConvexCell {
 public:
  /// The cube with edges of 2 `half`.
  void reset(double half);
  /// Keeps what is in the half-space.
  void clip(const HalfSpace& kept);
  bool isEmpty() const { return loops_.empty(); }
  double volume() const;

 private:
  struct Loop {
    std::uint32_t first, count;  // corners of a face, in order
  };
  std::vector<Eigen::Vector3d> corners_, next_corners_, rim_;
  std::vector<Loop> loops_, next_loops_;
  std::vector<double> height_;
  double half_ = 0;
};

}  // namespace spheretree::builder
