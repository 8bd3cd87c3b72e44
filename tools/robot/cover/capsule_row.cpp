// SPDX-License-Identifier: GPL-3.0-or-later
#include "robot/cover/capsule_row.h"

#include <algorithm>
#include <cmath>

namespace spheretree::robot {

BallRow ballRow(const LinkCapsule& capsule, std::size_t count) {
  const double length = (capsule.b - capsule.a).norm(), gaps = static_cast<double>(count) - 1;
  if (length == 0) return {{{capsule.a, capsule.radius}}, 0};
  // 4 (gaps^2 - 1) h^2 + b h - length^2 = 0; this form of its root holds for gaps = 1 and 0 as well.
  const double b = 8 * gaps * gaps * capsule.radius + 4 * length;
  const double root = std::sqrt(std::max(0.0, b * b + 16 * (gaps * gaps - 1) * length * length));
  const double exact = 2 * length * length / (b + root);
  BallRow row;
  // The balls stand where the exact overhang puts them, and are larger by more than the rounding errors.
  row.overhang = exact + 1e-12 * (capsule.radius + length + capsule.a.norm());
  const double first = gaps == 0 ? 0.5 : exact / length;  // as a share of the segment
  for (std::size_t i = 0; i < count; ++i) {
    const double share = gaps == 0 ? first : first + (1 - 2 * first) * static_cast<double>(i) / gaps;
    row.balls.push_back({capsule.a + share * (capsule.b - capsule.a), capsule.radius + row.overhang});
  }
  return row;
}

std::size_t ballsForOverhang(const LinkCapsule& capsule, double overhang, std::size_t max_count) {
  const double length = (capsule.b - capsule.a).norm();
  if (length == 0) return 1;
  const double between = 2 * std::sqrt(overhang * overhang + 2 * capsule.radius * overhang);
  const double gaps = std::ceil(std::max(0.0, length - 2 * overhang) / between);
  if (!(gaps + 1 < static_cast<double>(max_count))) return max_count;
  std::size_t count = 1 + static_cast<std::size_t>(gaps);
  while (count < max_count && ballRow(capsule, count).overhang > overhang) ++count;  // rounding
  return count;
}

}  // namespace spheretree::robot
