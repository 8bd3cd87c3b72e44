// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/tissue/fixed_regions.h"
#include "spheretree/core/rounding.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

namespace spheretree::pipeline {
namespace {

using Eigen::Vector3d;

/// Parses `count` finite numbers such as "1,2.5,-3".
std::optional<std::vector<double>> numbersIn(std::string_view text, std::size_t count) {
  std::vector<double> numbers;
  const char *at = text.data(), *const last = text.data() + text.size();
  while (true) {
    double value = 0;
    const auto [end, error] = std::from_chars(at, last, value);
    if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
    numbers.push_back(value);
    if (end == last) break;
    if (*end != ',') return std::nullopt;
    at = end + 1;
  }
  if (numbers.size() != count) return std::nullopt;
  return numbers;
}

}  // namespace

bool FixedRegions::holds(const Vector3d& p) const {
  return std::any_of(balls.begin(), balls.end(),
                     [&](const Sphere& s) { return (p - centreOf(s)).norm() <= static_cast<double>(s.radius); }) ||
         std::any_of(boxes.begin(), boxes.end(), [&](const Eigen::AlignedBox3d& box) { return box.contains(p); });
}

bool addFixedRegion(const std::string& text, FixedRegions& regions) {
  const std::string_view all(text);
  if (all.starts_with("sphere:")) {
    const auto n = numbersIn(all.substr(7), 4);
    if (!n || !((*n)[3] > 0)) return false;
    regions.balls.push_back({roundToFloat((*n)[0]), roundToFloat((*n)[1]), roundToFloat((*n)[2]), roundToFloat((*n)[3])});
    return true;
  }
  if (!all.starts_with("box:")) return false;
  const auto n = numbersIn(all.substr(4), 6);
  if (!n || !((*n)[0] <= (*n)[3] && (*n)[1] <= (*n)[4] && (*n)[2] <= (*n)[5])) return false;
  regions.boxes.emplace_back(Vector3d((*n)[0], (*n)[1], (*n)[2]), Vector3d((*n)[3], (*n)[4], (*n)[5]));
  return true;
}

void addLeaves(const SphereTree& tree, FixedRegions& regions) {
  for (const std::uint32_t leaf : levelSet(tree, tree.levelCount() - 1)) {
    const Sphere& s = tree.cover[leaf];
    regions.balls.push_back({roundToFloat(static_cast<double>(s.x) + tree.origin_mm[0]),
                             roundToFloat(static_cast<double>(s.y) + tree.origin_mm[1]),
                             roundToFloat(static_cast<double>(s.z) + tree.origin_mm[2]), s.radius});
  }
}

}  // namespace spheretree::pipeline
