// SPDX-License-Identifier: Apache-2.0
#include "search/find_pairs.h"

#include <algorithm>

#include "state/moving_bodies.h"
#include "state/step_memory.h"

namespace spheretree::runtime {

RelativePose relativePose(const ObjectView& object, const double rotation[9], const double position[3]) {
  RelativePose out;
  const double* const w = object.to_world;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c)
      out.rotation[3 * r + c] = static_cast<float>(w[r] * rotation[c] + w[3 + r] * rotation[3 + c] + w[6 + r] * rotation[6 + c]);
    double along = 0;
    for (int k = 0; k < 3; ++k) along += w[3 * k + r] * (position[k] - object.anchor[k]);
    out.offset[r] = static_cast<float>(along);
  }
  return out;
}

namespace {

/// What the search of the kernel reads and writes, for the tool at `pose`, whose root lies at `root` in the world.
PairSearch searchFor(const Configuration& pose, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& root, double margin, bool exact,
                     StepMemory& memory) noexcept {
  const CompiledScene& scene = memory.scene;
  // Bounds of the rounding errors of world coordinates in the broad phase, and of coordinates relative to the anchors
  // afterwards: offsets of near objects are at most the two reaches plus the margin.
  const double world_slack = kFloatRounding * (scene.tool.reach + scene.objects_reach + memory.farthest_anchor + root.norm());
  const double slack = kFloatRounding * (2 * (scene.tool.reach + scene.objects_reach) + margin + world_slack);
  PairSearch search{};
  const CompiledTree& tool = scene.toolTree(exact);
  search.tool = tool.bound.data();
  search.object_roots = memory.object_roots.data();
  search.tool_links = tool.links.data();
  search.exact_tool = scene.tool.exact.data();
  search.objects = exact ? memory.leaf_views.data() : memory.views.data();
  search.object_count = static_cast<std::uint32_t>(memory.views.size());
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) search.rotation[3 * r + c] = rotation(r, c);
    search.position[r] = pose.position[r];
    search.root[r] = static_cast<float>(root[r]);
  }
  search.root[3] = static_cast<float>(scene.tool_root_radius + margin + world_slack);
  search.margin = margin;
  search.inner_margin = static_cast<float>(margin + 2 * slack);
  search.sure_margin = exact ? static_cast<float>(margin - slack) : kFarAway;
  search.turned_tool = memory.turned_tool.data();
  search.turned_when = memory.turned_when.data();
  search.turn_count = memory.turn_count;
  search.near_objects = memory.near.data();
  search.leaves = memory.leaves.data();
  search.open_tool = memory.open_tool.data();
  search.open_object = memory.open_object.data();
  search.pairs = memory.pairs.data();
  search.near_counts = memory.near_counts.data();
  search.capacity = scene.step_limits.max_pairs;
  if (!exact && !scene.hulls.empty()) {
    search.hulls = spansOf(scene.hulls);
    search.hull_balls = scene.hulls.ball.data();
  }
  search.list_capacity = static_cast<std::uint32_t>(memory.open_tool.size());
  return search;
}

// The ways in which a hull may touch an item of an object, one bit for each.
std::uint32_t waysOf(std::uint32_t pair, std::uint32_t object, const StepMemory& memory) {
  const std::uint32_t balls = memory.scene.hulls.ballsOf(pair >> 16);
  if (balls == 1 || !memory.feelsSkin(object)) return 1;
  const CompiledSkin& skin = memory.scene.shapeOf(object).skin;
  return skin.ways[skin.tree.item[pair & 0xffff]] >> (balls == 2 ? 0 : 3) & 7u;
}

using Vector3f = Eigen::Vector3f;

// Whether the part of a hull is within the margin of the plane of the triangle. A search compares it with the sphere
// about the triangle, which is far larger where the two lie flat beside each other.
class NearPlane {
 public:
  NearPlane(const PairSearch& search, const CompiledHulls& hulls, const ObjectView& view)
      : hulls_(hulls), view_(view), reach_(search.inner_margin + view.allowance + view.motion) {
    const RelativePose pose = relativePose(view, search.rotation, search.position);
    rotation_ = Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(pose.rotation);
    offset_ = Vector3f(pose.offset);
  }
  bool operator()(std::uint32_t pair) const {
    if (!view_.still_patches) return true;
    const auto& p = view_.still_patches[view_.items[pair & 0xffff]].position;
    const Vector3f corner(p[0]), across = (Vector3f(p[1]) - corner).cross(Vector3f(p[2]) - corner),
                                 normal = rotation_.transpose() * across;  // in the axes of the tool
    const std::uint32_t slot = pair >> 16;
    const Sphere &first = hulls_.ball[slot], &one = hulls_.span1[slot], &two = hulls_.span2[slot];
    const float length = across.norm(), at = across.dot(offset_ - corner) + normal.dot(Vector3f(first.x, first.y, first.z)),
                along1 = normal.dot(Vector3f(one.x, one.y, one.z)), along2 = normal.dot(Vector3f(two.x, two.y, two.z));
    const float swell1 = length * one.radius, swell2 = length * two.radius, reach = length * (first.radius + reach_);
    const float above = at + std::min({0.0f, along1 - swell1, along2 - swell2}),
                below = at + std::max({0.0f, along1 + swell1, along2 + swell2});
    return above <= reach && below >= -reach;
  }

 private:
  const CompiledHulls& hulls_;
  const ObjectView& view_;
  float reach_;
  Eigen::Matrix3f rotation_;  // tool axes to those of the object
  Vector3f offset_;
};

// Each pair with a cone or slab becomes one for each of its ways. Returns the number of pairs. The pairs are first
// moved to the end of the memory, so that none is overwritten before it is read.
std::uint32_t spreadWays(const PairSearch& search, std::uint32_t count, StepMemory& memory) noexcept {
  std::uint32_t* const first = memory.pairs.data();
  const std::uint32_t* next = first + memory.pairs.size() - count;
  std::copy_backward(first, first + count, first + memory.pairs.size());
  std::uint32_t* to = first;
  for (std::uint32_t n = 0; n < search.near_count; ++n) {
    const std::uint32_t* const begin = to;
    const NearPlane isNear(search, memory.scene.hulls, memory.views[memory.near[n]]);
    for (std::uint32_t k = 0; k < memory.near_counts[n]; ++k, ++next) {
      const std::uint32_t pair = *next;
      if (!isNear(pair)) continue;
      for (std::uint32_t ways = waysOf(pair, memory.near[n], memory); ways; ways &= ways - 1)
        *to++ = pair + (static_cast<std::uint32_t>(__builtin_ctz(ways)) * memory.scene.hulls.ways_apart << 16);
    }
    memory.near_counts[n] = static_cast<std::uint32_t>(to - begin);
  }
  return static_cast<std::uint32_t>(to - first);
}

}  // namespace

PairSet findPairs(const Configuration& pose, double margin, PairsOf of, std::uint32_t max_work, StepMemory& memory) noexcept {
  const CompiledScene& scene = memory.scene;
  const Eigen::Matrix3d rotation = pose.orientation.normalized().toRotationMatrix();
  const Eigen::Vector3d root = rotation * scene.tool_root + pose.position;
  bringNear(root, scene.tool_root_radius + margin, memory);
  if (memory.turn_count > 0xf0000000u) {  // before old marks could be mistaken for new ones
    std::fill(memory.turned_when.begin(), memory.turned_when.end(), 0u);
    memory.turn_count = 0;
  }
  PairSearch search = searchFor(pose, rotation, root, margin, of == PairsOf::LeavesExactly, memory);
  search.max_work = max_work;
  search.near_count = memory.kernel->findNear(search);
  if (memory.bodies.size() > 1)
    for (std::uint32_t n = 0; n < search.near_count; ++n) follow(memory.near[n], memory);
  PairSearchResult found = memory.kernel->findPairs(search);
  if (search.hulls.way && !found.coarse) found.count = spreadWays(search, found.count, memory);
  memory.turn_count += search.near_count;

  memory.runs.clear();
  for (std::uint32_t n = 0, begin = 0; n < search.near_count; ++n) {
    const std::uint32_t count = memory.near_counts[n];
    if (count > 0) memory.runs.push_back({memory.near[n], begin, count});
    begin += count;
  }
  PairSet set;
  set.work = found.work;
  set.coarse = found.coarse;
  set.pairs = {memory.pairs.data(), found.count};
  set.runs = memory.runs;
  return set;
}

}  // namespace spheretree::runtime
