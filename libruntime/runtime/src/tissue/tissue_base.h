// SPDX-License-Identifier: Apache-2.0
// The shape to which displacements of soft tissue are relative for large deformations. A solver outside of the step
// computes where it has to be; it moves there from step to step.
// Units: mm; frame: axes of the object. No allocation after construction.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

namespace spheretree::runtime {

/// The largest length of `of` over the x, y, z of each node.
template <class Of>
double longestOf(std::size_t size, const Of& of) {
  float max2 = 0;
  for (std::size_t i = 0; i < size; i += 3) {
    const float x = of(i), y = of(i + 1), z = of(i + 2);
    max2 = std::max(max2, x * x + y * y + z * z);
  }
  return std::sqrt(static_cast<double>(max2));
}

class TissueBase {
 public:
  explicit TissueBase(std::size_t nodes) : place_(3 * nodes), start_(3 * nodes), way_(3 * nodes) {}

  /// Displacement of each pressed node from the shape at rest: x, y, z.
  const std::vector<float>& place() const { return place_; }
  /// Whether it moved at the beginning of this step, and then by how much.
  bool moves() const { return moves_; }
  const std::vector<float>& way() const { return way_; }

  /// Returns to the shape at rest.
  void reset();
  /// Sets the target: x, y, z of each pressed node. `surface` must stay valid until the next call.
  void aim(std::span<const float> surface);
  /// Begins a step: moves by `share` of the way to the target, but no node by more than `max_motion`. Returns moves().
  bool follow(double share, double max_motion);
  /// Returns to where it was before the last call of follow().
  void takeBack();

 private:
  std::vector<float> place_, start_, way_;  // now; at the beginning of the step; from there to here, if moves_
  std::span<const float> aim_;              // empty: it does not move
  double left_ = 0;                         // largest remaining way of a node to its target [mm]
  bool moves_ = false;
};

}  // namespace spheretree::runtime
