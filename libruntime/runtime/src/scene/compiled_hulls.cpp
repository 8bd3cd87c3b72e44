// SPDX-License-Identifier: Apache-2.0
#include "scene/compiled_hulls.h"

#include <algorithm>

namespace spheretree::runtime {
namespace {

Sphere minus(const Sphere& a, const Sphere& b) { return {a.x - b.x, a.y - b.y, a.z - b.z, a.radius - b.radius}; }

}  // namespace

CompiledHulls compileHulls(const Hulls& hulls, const Eigen::Vector3d& origin) {
  CompiledHulls out;
  if (hulls.empty()) return out;
  std::vector<Sphere> spheres;
  for (const HullPart& part : hulls.parts) spheres.push_back(enclose(hulls, part));
  out.tree = compileTree(hulls.search, spheres, origin, TreeOver::Triangles);
  out.ways_apart = static_cast<std::uint32_t>(out.tree.item.size());
  out.span1 = out.span2 = std::vector<Sphere>(3 * out.ways_apart);
  for (std::uint32_t way = 0; way < 3; ++way)
    for (std::uint32_t slot = 0; slot < out.ways_apart; ++slot) {
      const Block& block = out.tree.bound[slot / 8];
      out.way.push_back(way);
      out.ball.push_back({block.x[slot % 8], block.y[slot % 8], block.z[slot % 8], block.r[slot % 8]});
      if (out.tree.item[slot] == kNoItem) continue;
      const HullPart& part = hulls.parts[out.tree.item[slot]];
      const Sphere& first = hulls.balls[part[0]];
      const Eigen::Vector3f at = (centreOf(first) + origin).cast<float>();
      out.ball.back() = {at.x(), at.y(), at.z(), first.radius};
      if (part[1] != kNoHullBall) out.span1[slot + way * out.ways_apart] = minus(hulls.balls[part[1]], first);
      if (part[2] != kNoHullBall) out.span2[slot + way * out.ways_apart] = minus(hulls.balls[part[2]], first);
    }
  out.smallest_radius = std::ranges::min_element(hulls.balls, {}, &Sphere::radius)->radius;
  return out;
}

}  // namespace spheretree::runtime
