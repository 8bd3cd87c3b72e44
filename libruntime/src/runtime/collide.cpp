// SPDX-License-Identifier: Apache-2.0
#include "spheretree/runtime/collide.h"

#include <algorithm>

#include "kernel.h"
#include "spheretree/runtime/workspace.h"

namespace spheretree::runtime {
namespace {

// Float rounding moves a distance by less than this times the lengths involved: at most 12 roundings of 2^-24 each on either side.
constexpr double kRounding = 1e-6;

TreeView viewOf(const CompiledTree& tree) { return {tree.bound.data(), tree.child_block.data(), tree.inner_lanes.data()}; }

}  // namespace

bool isAvailable(Kernel kernel) { return kernel != Kernel::Avx2 || avx2Kernel() != nullptr; }

PairSet findPairs(const Scene& scene, const Configuration& pose, double margin, bool exact, std::uint32_t max_work,
                  Workspace& workspace) noexcept {
  PairSet set;
  const Eigen::Matrix3d rotation = pose.orientation.normalized().toRotationMatrix();
  const Eigen::Vector3d root = rotation * scene.tool_root + pose.position;
  std::vector<std::uint32_t>& near_objects = workspace.near_objects;
  near_objects.clear();
  for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
    const CompiledObject& object = scene.objects[i];
    const double slack = kRounding * (scene.tool.reach + object.tree.reach + (pose.position - object.anchor).norm());
    const double reach = scene.tool_root_radius + object.root_radius + margin + slack;
    if ((root - object.anchor).squaredNorm() <= reach * reach) near_objects.push_back(i);
  }
  workspace.runs.clear();
  set.work = static_cast<std::uint32_t>((scene.objects.size() + 7) / 8);
  if (near_objects.empty()) return set;

  PairSearch search;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) {
      search.rotation[3 * r + c] = static_cast<float>(rotation(r, c));
      search.exact.rotation[3 * r + c] = rotation(r, c);
    }
  if (++workspace.pose_count == 0) {  // after 2^32 searches the old marks would come round again
    std::fill(workspace.turned_when.begin(), workspace.turned_when.end(), 0u);
    workspace.pose_count = 1;
  }
  search.tool = viewOf(scene.tool);
  search.turned_tool = workspace.turned_tool.data();
  search.turned_when = workspace.turned_when.data();
  search.now = workspace.pose_count;
  search.lists[0] = workspace.list_a.data();
  search.lists[1] = workspace.list_b.data();
  std::uint32_t count = 0;
  for (std::size_t n = 0; n < near_objects.size(); ++n) {
    const std::uint32_t i = near_objects[n];
    const CompiledObject& object = scene.objects[i];
    const Eigen::Vector3d offset = pose.position - object.anchor;
    const double slack = kRounding * (scene.tool.reach + object.tree.reach + offset.norm());
    search.object = viewOf(object.tree);
    for (int k = 0; k < 3; ++k) {
      search.offset[k] = static_cast<float>(offset[k]);
      search.exact.offset[k] = offset[k];
    }
    search.exact.margin = margin;
    search.exact.tool = exact ? scene.tool.exact.data() : nullptr;
    search.exact.object = object.tree.exact.data();
    search.inner_margin = static_cast<float>(margin + 2 * slack);
    search.maybe_margin = static_cast<float>(margin + slack);
    search.sure_margin = exact ? static_cast<float>(margin - slack) : search.maybe_margin;
    search.pairs = workspace.pairs.data() + count;
    // 64 pairs are kept for each object that is still to come, so that a full list never leaves one out.
    const auto later = static_cast<std::uint32_t>(64 * (near_objects.size() - n - 1));
    search.capacity = scene.step_limits.max_pairs - count - later;
    search.max_work = max_work > set.work ? max_work - set.work : 0;
    const PairSearchResult found = workspace.kernel->findPairs(search);
    set.work += found.work;
    set.coarse |= found.coarse;
    if (found.count == 0) continue;
    workspace.runs.push_back({i, count, found.count});
    count += found.count;
  }
  set.pairs = {workspace.pairs.data(), count};
  set.runs = workspace.runs;
  return set;
}

}  // namespace spheretree::runtime
