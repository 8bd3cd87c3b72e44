// SPDX-License-Identifier: GPL-3.0-or-later
#include "cut/swept_burr.h"

#include <algorithm>

namespace spheretree::builder {

using Eigen::Vector3d;

Vector3d nearestOnAxis(const Capsule& capsule, const Vector3d& p) {
  const Vector3d along = capsule.to - capsule.from;
  const double length2 = along.squaredNorm();
  if (!(length2 > 0)) return capsule.from;
  return capsule.from + std::clamp((p - capsule.from).dot(along) / length2, 0.0, 1.0) * along;
}

std::vector<Capsule> sweptCapsules(std::span<const BurrPath> paths, double slack) {
  constexpr std::size_t kLongest = 256;  // steps in a capsule: bounds the cost of a burr that rests
  std::vector<Capsule> out;
  for (const BurrPath& path : paths) {
    // The path between two of its points comes near every point of the chord between them, since it is connected.
    std::size_t from = 0;
    while (from + 1 < path.centres.size()) {
      std::size_t to = from + 1;
      const auto isNear = [&](std::size_t end) {
        const Capsule chord{path.centres[from], path.centres[end], path.radius};
        return std::all_of(path.centres.begin() + static_cast<std::ptrdiff_t>(from),
                           path.centres.begin() + static_cast<std::ptrdiff_t>(end),
                           [&](const Vector3d& p) { return (p - nearestOnAxis(chord, p)).norm() <= slack; });
      };
      while (slack > 0 && to + 1 < path.centres.size() && to - from < kLongest && isNear(to + 1)) ++to;
      out.push_back({path.centres[from], path.centres[to], path.radius});
      from = to;
    }
  }
  return out;
}

}  // namespace spheretree::builder
