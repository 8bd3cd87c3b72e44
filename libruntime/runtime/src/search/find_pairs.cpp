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

// Each pair with a cone or slab becomes one for each of its ways. Returns the number of pairs. The pairs are first
// moved to the end of the memory, so that none is overwritten before it is read.
std::uint32_t spreadWays(const PairSearch& search, std::uint32_t count, StepMemory& memory) noexcept {
  const CompiledScene& scene = memory.scene;
  std::uint32_t* const first = memory.pairs.data();
  std::copy_backward(first, first + count, first + memory.pairs.size());
  RowRequest request{};
  request.pairs = first + memory.pairs.size() - count;
  request.tool = scene.hulls.ball.data();
  request.hulls = search.hulls;
  HullWays ways{nullptr, scene.hulls.ways_apart, 0, 0, first};
  // The tool moves by at most the margin; bodies that move turn the objects as well.
  ways.turn = memory.moving_count > 0 ? kFarAway : static_cast<float>(search.margin / scene.tool.reach);
  for (std::uint32_t n = 0; n < search.near_count; ++n) {
    const std::uint32_t object = memory.near[n];
    const ObjectView& view = memory.views[object];
    request.count = memory.near_counts[n];
    if (memory.feelsSkin(object)) {
      request.pose = relativePose(view, search.rotation, search.position);
      request.patches = view.patches;
      request.items = view.items;
      ways.ways = scene.shapeOf(object).skin.ways.data();
      ways.reach = search.inner_margin + view.allowance + view.motion;
      memory.near_counts[n] = memory.kernel->spreadWays(request, ways);
    } else {
      std::copy_n(request.pairs, request.count, ways.to);
    }
    request.pairs += request.count;
    ways.to += memory.near_counts[n];
  }
  return static_cast<std::uint32_t>(ways.to - first);
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
