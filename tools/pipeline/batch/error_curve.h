// SPDX-License-Identifier: GPL-3.0-or-later
// How the error of a tree falls with its leaves, and how to share leaves among trees so that the largest error is
// least.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace spheretree::pipeline {

/// Measured points; between and beyond them the error is a power of the number of leaves.
class ErrorCurve {
 public:
  /// `leaves` >= 1, `error` > 0. A point that is no better than one with fewer leaves is forgotten, and so are those
  /// that it outdoes.
  void add(double leaves, double error);
  /// The same, but all that was known moves along, by the same factor: it was found with another quality.
  void moveTo(double leaves, double error);
  /// > 0, falls with `leaves`. Without points 1 / leaves.
  double errorAt(double leaves) const;

 private:
  struct Point {
    double leaves, error;  // logarithms
  };
  std::vector<Point> points_;  // leaves ascend, errors descend
};

struct LeafShares {
  std::vector<std::size_t> leaves;
  double error = 0;  // of all that could have more leaves
};

/// Whole numbers of leaves, each from 1 to `most`, together at most `total` (>= one each), such that no error is larger
/// than need be: the largest is the least possible, and all that could have more leaves share one error.
LeafShares shareLeaves(std::span<const ErrorCurve> curves, std::span<const std::size_t> most, std::size_t total);

}  // namespace spheretree::pipeline
