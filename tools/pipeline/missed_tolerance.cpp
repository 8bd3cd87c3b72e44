// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/missed_tolerance.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "spheretree/core/sphere_tree.h"

namespace spheretree::pipeline {

constexpr double kNearlyFull = 1.25;  // times the leaves of a tree: its room

std::string missedTolerance(double tolerance_mm, double kept_mm, std::size_t leaves) {
  const double estimate = static_cast<double>(leaves) * kept_mm / tolerance_mm,
               digits = std::pow(10, std::max(0.0, std::floor(std::log10(estimate)) - 1)), needed = std::ceil(estimate / digits) * digits;
  int levels = 1;
  double full = 1;
  // A tree that is nearly full has missed the tolerance with as many levels.
  for (; levels < kMaxLevels && full < std::max(needed, kNearlyFull * static_cast<double>(leaves)); ++levels) full *= kMaxBranching;
  char text[400];
  int length = std::snprintf(text, sizeof text,
                             "the tolerance of %.3g mm is not met; the best result was written: %zu leaves with an overhang of %.3g mm. ",
                             tolerance_mm, leaves, kept_mm);
  const std::size_t left = sizeof text - static_cast<std::size_t>(length);
  if (needed <= full) {
    std::snprintf(text + length, left, "The tolerance needs about %.0f leaves: %d levels with %d children for each node.", needed, levels,
                  kMaxBranching);
  } else {
    std::snprintf(text + length, left, "The largest tree, %.0f leaves on %d levels, reaches about %.2g mm.", full, kMaxLevels,
                  kept_mm * static_cast<double>(leaves) / full);
  }
  return text;
}

}  // namespace spheretree::pipeline
