// SPDX-License-Identifier: Apache-2.0
#include "spheretree/runtime/collide.h"

#include <algorithm>
#include <vector>

#include "kernel.h"
#include "spheretree/runtime/workspace.h"

namespace spheretree::runtime {
namespace {

// Float rounding moves a distance by less than this times the lengths involved: at most 12 roundings of 2^-24 each on either side.
constexpr double kRounding = 1e-6;

}  // namespace

bool isAvailable(Kernel kernel) { return kernel != Kernel::Avx2 || avx2Kernel() != nullptr; }

namespace {

PairSet searchAmong(const Scene& scene, const std::vector<Block>& roots, const Configuration& pose, double margin, bool exact,
                    std::uint32_t max_work, Targets& targets, Workspace& workspace) noexcept {
  const Eigen::Matrix3d rotation = pose.orientation.normalized().toRotationMatrix();
  const Eigen::Vector3d root = rotation * scene.tool_root + pose.position;
  // Rounding of world coordinates in the broad phase, and of what is about the anchors afterwards: offsets of near objects are no longer
  // than the two reaches and the margin.
  const double world_slack = kRounding * (scene.tool.reach + scene.objects_reach + scene.farthest_anchor + root.norm());
  const double slack = kRounding * (2 * (scene.tool.reach + scene.objects_reach) + margin + world_slack);
  PairSearch search;
  search.tool = scene.tool.bound.data();
  search.object_roots = roots.data();
  search.tool_links = scene.tool.links.data();
  search.exact_tool = scene.tool.exact.data();
  search.objects = targets.views.data();
  search.object_count = static_cast<std::uint32_t>(targets.views.size());
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) search.rotation[3 * r + c] = rotation(r, c);
    search.position[r] = pose.position[r];
    search.root[r] = static_cast<float>(root[r]);
  }
  search.root[3] = static_cast<float>(scene.tool_root_radius + margin + world_slack);
  search.margin = margin;
  search.inner_margin = static_cast<float>(margin + 2 * slack);
  search.sure_margin = exact ? static_cast<float>(margin - slack) : search.inner_margin;
  if (++workspace.pose_count == 0) {  // after 2^32 searches the old marks would come round again
    std::fill(workspace.turned_when.begin(), workspace.turned_when.end(), 0u);
    workspace.pose_count = 1;
  }
  search.turned_tool = workspace.turned_tool.data();
  search.turned_when = workspace.turned_when.data();
  search.now = workspace.pose_count;
  search.near_objects = targets.near.data();
  search.near_views = targets.near_views.data();
  search.leaves = workspace.leaves.data();
  search.open_tool = workspace.open_tool.data();
  search.open_object = workspace.open_object.data();
  search.pairs = targets.pairs.data();
  search.near_counts = targets.near_counts.data();
  search.capacity = scene.step_limits.max_pairs;
  search.list_capacity = static_cast<std::uint32_t>(workspace.open_tool.size());
  search.max_work = max_work;
  const PairSearchResult found = workspace.kernel->findPairs(search);

  targets.runs.clear();
  for (std::uint32_t n = 0, begin = 0; n < found.near_count; ++n) {
    const std::uint32_t count = targets.near_counts[n];
    if (count > 0) targets.runs.push_back({targets.near[n], begin, count});
    begin += count;
  }
  PairSet set;
  set.work = found.work;
  set.coarse = found.coarse;
  set.pairs = {targets.pairs.data(), found.count};
  set.runs = targets.runs;
  return set;
}

}  // namespace

PairSet findPairs(const Scene& scene, const Configuration& pose, double margin, bool exact, std::uint32_t max_work,
                  Workspace& workspace) noexcept {
  return searchAmong(scene, scene.object_roots, pose, margin, exact, max_work, workspace.objects, workspace);
}

PairSet findBridges(const Scene& scene, const Configuration& pose, double margin, std::uint32_t max_work, Workspace& workspace) noexcept {
  Targets& targets = workspace.bridges;
  PairSet set = searchAmong(scene, scene.bridge_roots, pose, margin, false, max_work, targets, workspace);
  if (!set.coarse) return set;
  // Inner nodes stand for no bridge in particular: they are left out.
  std::uint32_t count = 0;
  for (PairRun& run : targets.runs) {
    const std::vector<BlockLinks>& links = scene.bridges[run.object].tree.links;
    const std::uint32_t begin = count;
    for (std::uint32_t i = run.begin; i < run.begin + run.count; ++i) {
      const std::uint32_t pair = targets.pairs[i], slot = pair & 0xffff;
      if (!scene.tool.isInner(pair >> 16) && slot % 8 >= links[slot / 8].inner) targets.pairs[count++] = pair;
    }
    run.begin = begin;
    run.count = count - begin;
  }
  set.pairs = {targets.pairs.data(), count};
  return set;
}

}  // namespace spheretree::runtime
