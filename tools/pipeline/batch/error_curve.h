// SPDX-License-Identifier: GPL-3.0-or-later
// The error of a tree as a function of its number of leaves, and the distribution of leaves among trees that minimises
// the largest error.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace spheretree::pipeline {

/// Interpolates measured points: between and beyond them, the error is a power of the number of leaves.
class ErrorCurve {
 public:
  /// `leaves` >= 1, `error` > 0. A point that is not better than one with fewer leaves is ignored, and existing points
  /// that it surpasses are removed.
  void add(double leaves, double error);
  /// As add(), but existing points are scaled by the same factor, because they were measured with another quality.
  void moveTo(double leaves, double error);
  /// > 0, decreases with `leaves`. Without points: 1 / leaves.
  double errorAt(double leaves) const;

 private:
  struct Point {
    double leaves, error;  // their logarithms
  };
  std::vector<Point> points_;  // leaves increase, errors decrease
};

struct LeafShares {
  std::vector<std::size_t> leaves;
  double error = 0;  // common error of all trees that could have more leaves
};

/// Integer numbers of leaves, each from 1 to `max_leaves`, with a sum of at most `total` (>= number of trees), that
/// minimise the largest error; all trees that could have more leaves have about the same error.
LeafShares shareLeaves(std::span<const ErrorCurve> curves, std::span<const std::size_t> max_leaves, std::size_t total);

}  // namespace spheretree::pipeline
