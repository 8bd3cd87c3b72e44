// SPDX-License-Identifier: Apache-2.0
#include "spheretree/runtime/contact.h"

#include <algorithm>
#include <limits>

#include "kernel.h"
#include "spheretree/runtime/workspace.h"

namespace spheretree::runtime {

namespace {

// The rows past the end are in no one's way.
void padRows(float* memory, std::size_t stride, std::uint32_t count) {
  for (std::size_t k = 0; k < 8; ++k) std::fill_n(memory + k * stride + count, 8, k == 6 ? -1e30f : 0.0f);
}

}  // namespace

RowSet makeRows(const Scene& scene, const PairSet& set, const Configuration& pose, RowForm form, const Eigen::Matrix3d& axes,
                Workspace& workspace) noexcept {
  RowSet out;
  float* const memory = workspace.row_memory.get();
  for (std::size_t k = 0; k < 6; ++k) out.rows.a[k] = memory + k * workspace.row_stride;
  out.rows.b = memory + 6 * workspace.row_stride;
  out.weight = memory + 7 * workspace.row_stride;
  out.rows.count = out.leaf_count = static_cast<std::uint32_t>(set.pairs.size());
  out.smallest_gap = std::numeric_limits<float>::infinity();
  if (set.pairs.empty()) return out;

  const Eigen::Matrix3d rotation = pose.orientation.normalized().toRotationMatrix();
  RowRequest request;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) {
      request.rotation[3 * r + c] = static_cast<float>(rotation(r, c));
      request.axes[3 * r + c] = static_cast<float>(axes(c, r));
    }
  request.tool = scene.tool.spheres.data();
  request.inverse_angle_length = static_cast<float>(1 / scene.angle_length);
  request.squared = form == RowForm::SquaredDistance;
  for (const PairRun& run : set.runs) {
    const CompiledObject& object = scene.objects[run.object];
    const Eigen::Vector3d offset = pose.position - object.anchor;
    for (int k = 0; k < 3; ++k) request.offset[k] = static_cast<float>(offset[k]);
    request.pairs = set.pairs.data() + run.begin;
    request.count = run.count;
    request.object = object.tree.spheres.data();
    for (std::size_t k = 0; k < 6; ++k) request.a[k] = memory + k * workspace.row_stride + run.begin;
    request.b = memory + 6 * workspace.row_stride + run.begin;
    request.weight = memory + 7 * workspace.row_stride + run.begin;
    out.smallest_gap = std::min(out.smallest_gap, workspace.kernel->makeRows(request));
  }
  padRows(memory, workspace.row_stride, out.rows.count);
  return out;
}

namespace {

// Calls `use(request, run)` for the pairs of each run.
template <class Use>
void forEachRun(const Scene& scene, std::span<PairRun> runs, const std::uint32_t* pairs, const Configuration& pose, double most_gap,
                const Use& use) {
  const Eigen::Matrix3d rotation = pose.orientation.normalized().toRotationMatrix();
  BridgeRequest request;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) request.rotation[3 * r + c] = static_cast<float>(rotation(r, c));
  request.tool = scene.tool.spheres.data();
  request.inverse_angle_length = static_cast<float>(1 / scene.angle_length);
  request.most_gap = static_cast<float>(most_gap);
  for (PairRun& run : runs) {
    const CompiledBridges& target = scene.bridges[run.object];
    const Eigen::Vector3d offset = pose.position - scene.objects[target.object].anchor;
    for (int k = 0; k < 3; ++k) request.offset[k] = static_cast<float>(offset[k]);
    request.pairs = pairs + run.begin;
    request.count = run.count;
    request.bridges = target.tree.of_slot.data();
    use(request, run);
  }
}

// Of `set`, the bridges that may be touched within `margin`.
void keepNear(const Scene& scene, const Configuration& pose, double margin, PairSet& set, Workspace& workspace) {
  if (set.pairs.empty()) return;
  std::uint32_t* const pairs = workspace.bridges.pairs.data();
  std::uint32_t count = 0;
  const float slack = 1e-5f * static_cast<float>(scene.tool.reach + scene.objects_reach + margin);
  forEachRun(scene, workspace.bridges.runs, pairs, pose, margin, [&](BridgeRequest& request, PairRun& run) {
    request.most_gap += slack;
    const std::uint32_t kept = workspace.kernel->nearBridges(request, pairs + count);
    run.begin = count;
    run.count = kept;
    count += kept;
  });
  set.pairs = {pairs, count};
}

}  // namespace

PairSet findNearBridges(const Scene& scene, const Configuration& pose, double margin, std::uint32_t max_work,
                        Workspace& workspace) noexcept {
  PairSet set = findBridges(scene, pose, margin, max_work, workspace);
  set.work += static_cast<std::uint32_t>(3 * (set.pairs.size() / 8 + set.runs.size()));
  keepNear(scene, pose, margin, set, workspace);
  return set;
}

void narrow(const Scene& scene, const RowSet& rows, const Configuration& pose, double margin, PairSet& pairs, PairSet& bridges,
            Workspace& workspace) noexcept {
  std::uint32_t* const names = workspace.objects.pairs.data();
  std::uint32_t count = 0;
  const float most = static_cast<float>(margin * (1 + 1e-6));
  for (PairRun& run : workspace.objects.runs) {
    const std::uint32_t begin = count;
    for (std::uint32_t i = run.begin; i < run.begin + run.count; ++i)
      if (-rows.rows.b[i] <= most * rows.weight[i]) names[count++] = names[i];
    run.begin = begin;
    run.count = count - begin;
  }
  pairs.pairs = {names, count};
  keepNear(scene, pose, margin, bridges, workspace);
}

void addBridgeRows(const Scene& scene, const PairSet& bridges, const Configuration& pose, double most_gap, RowSet& out,
                   Workspace& workspace) noexcept {
  if (bridges.pairs.empty()) return;
  forEachRun(scene, workspace.bridges.runs, bridges.pairs.data(), pose, most_gap, [&](const BridgeRequest& request, const PairRun& run) {
    RowMemory memory;
    float* const first = workspace.row_memory.get() + out.rows.count;
    for (std::size_t k = 0; k < 6; ++k) memory.a[k] = first + k * workspace.row_stride;
    memory.b = first + 6 * workspace.row_stride;
    memory.weight = first + 7 * workspace.row_stride;
    workspace.kernel->makeBridgeRows(request, memory);
    out.rows.count += run.count;
  });
  padRows(workspace.row_memory.get(), workspace.row_stride, out.rows.count);
}

}  // namespace spheretree::runtime
