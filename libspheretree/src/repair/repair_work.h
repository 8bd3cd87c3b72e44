// SPDX-License-Identifier: GPL-3.0-or-later
// The bound of the work of a repair. Every loop of a step whose length the number of triangles does not bound tightly
// spends units of it, so that a step ends in bounded time whatever the mesh, on the same triangle every time.
#pragma once

#include <cstddef>
#include <limits>

#include "spheretree/builder/progress.h"

namespace spheretree::builder {

/// Units of an exact construction: of a pair of triangles that cross, a point or a cut in a triangle, a winding number.
inline constexpr std::size_t kConstruction = 20;

/// Thrown by RepairWork::spend(): the step gives up.
struct TooMuchWork {};

class RepairWork {
 public:
  /// `units`: about a microsecond each.
  explicit RepairWork(const Progress& progress, std::size_t units = std::numeric_limits<std::size_t>::max())
      : progress_(progress), left_(units) {}

  /// @throws Cancelled after an interrupt; TooMuchWork
  void spend(std::size_t units) {
    progress_.check();
    if (units > left_) throw TooMuchWork{};
    left_ -= units;
  }
  std::size_t left() const { return left_; }

 private:
  const Progress& progress_;
  std::size_t left_;
};

}  // namespace spheretree::builder
