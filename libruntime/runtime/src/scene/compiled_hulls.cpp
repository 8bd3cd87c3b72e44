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
  const std::vector<HullItem> items = itemsOf(hulls);
  std::vector<Sphere> spheres;
  for (const HullItem& item : items) {
    out.part.push_back(item.part);
    spheres.push_back(item.way == 0 ? enclose(hulls, hulls.parts[item.part]) : spheres.back());
  }
  out.tree = compileTree(hulls.search, spheres, origin, TreeOver::Triangles);
  const std::size_t slots = out.tree.item.size();
  out.span1 = out.span2 = std::vector<Sphere>(slots);
  out.way = std::vector<std::uint32_t>(slots);
  for (std::size_t slot = 0; slot < slots; ++slot) {
    const Block& block = out.tree.bound[slot / 8];
    out.ball.push_back({block.x[slot % 8], block.y[slot % 8], block.z[slot % 8], block.r[slot % 8]});
    if (out.tree.item[slot] == kNoItem) continue;
    const HullItem& item = items[out.tree.item[slot]];
    const HullPart& part = hulls.parts[item.part];
    const Sphere& first = hulls.balls[part[0]];
    const Eigen::Vector3f at = (centreOf(first) + origin).cast<float>();
    out.ball.back() = {at.x(), at.y(), at.z(), first.radius};
    if (part[1] != kNoHullBall) out.span1[slot] = minus(hulls.balls[part[1]], first);
    if (part[2] != kNoHullBall) out.span2[slot] = minus(hulls.balls[part[2]], first);
    out.way[slot] = item.way;
  }
  out.smallest_radius = std::ranges::min_element(hulls.balls, {}, &Sphere::radius)->radius;
  return out;
}

}  // namespace spheretree::runtime
