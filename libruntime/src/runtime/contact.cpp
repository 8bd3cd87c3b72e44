// SPDX-License-Identifier: Apache-2.0
#include "spheretree/runtime/contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernel.h"
#include "spheretree/runtime/workspace.h"

namespace spheretree::runtime {

namespace {

// The rows past the end are in no one's way.
void padRows(float* memory, std::size_t stride, std::uint32_t count) {
  for (std::size_t k = 0; k < 8; ++k) std::fill_n(memory + k * stride + count, 8, k == 6 ? -1e30f : 0.0f);
}

Eigen::Vector3d centre(const Sphere& s) { return {s.x, s.y, s.z}; }

}  // namespace

RowSet makeRows(const Scene& scene, const PairSet& set, const Configuration& pose, RowForm form, const Eigen::Matrix3d& axes,
                Workspace& workspace) noexcept {
  RowSet out;
  float* const memory = workspace.row_memory.get();
  for (std::size_t k = 0; k < 6; ++k) out.rows.a[k] = memory + k * workspace.row_stride;
  out.rows.b = memory + 6 * workspace.row_stride;
  out.weight = memory + 7 * workspace.row_stride;
  out.rows.count = static_cast<std::uint32_t>(set.pairs.size());
  out.smallest_gap = std::numeric_limits<float>::infinity();
  if (set.pairs.empty()) return out;

  const Eigen::Matrix3d rotation = pose.orientation.normalized().toRotationMatrix();
  RowRequest request;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) {
      request.rotation[3 * r + c] = static_cast<float>(rotation(r, c));
      request.axes[3 * r + c] = static_cast<float>(axes(c, r));
    }
  request.tool = scene.tool.cover_records.data();
  request.inverse_angle_length = static_cast<float>(1 / scene.angle_length);
  request.squared = form == RowForm::SquaredDistance;
  for (const PairRun& run : set.runs) {
    const CompiledObject& object = scene.objects[run.object];
    const Eigen::Vector3d offset = pose.position - object.anchor;
    for (int k = 0; k < 3; ++k) request.offset[k] = static_cast<float>(offset[k]);
    request.pairs = set.pairs.data() + run.begin;
    request.count = run.count;
    request.object = object.tree.cover_records.data();
    for (std::size_t k = 0; k < 6; ++k) request.a[k] = memory + k * workspace.row_stride + run.begin;
    request.b = memory + 6 * workspace.row_stride + run.begin;
    request.weight = memory + 7 * workspace.row_stride + run.begin;
    out.smallest_gap = std::min(out.smallest_gap, workspace.kernel->makeRows(request));
  }
  padRows(memory, workspace.row_stride, out.rows.count);
  return out;
}

void findBridges(const Scene& scene, const PairSet& set, const Configuration& pose, double margin, const RowSet& rows,
                 Workspace& workspace) noexcept {
  workspace.near_bridges.clear();
  const Eigen::Matrix3d rotation = pose.orientation.toRotationMatrix();
  for (const PairRun& run : set.runs) {
    const CompiledTree& tree = scene.objects[run.object].tree;
    const Bridges& bridges = tree.bridges;
    if (bridges.all.empty()) continue;
    const Eigen::Vector3d offset = pose.position - scene.objects[run.object].anchor;
    const float far = static_cast<float>(margin) + bridges.deepest;
    for (std::uint32_t i = run.begin; i < run.begin + run.count; ++i) {
      const float gap = -rows.rows.b[i] / rows.weight[i];
      if (gap > far) continue;
      const std::uint32_t tool_slot = set.pairs[i] >> 16, slot = set.pairs[i] & 0xffff;
      const Sphere& tool = scene.tool.cover_records[tool_slot];
      const Eigen::Vector3d at = rotation * centre(tool) + offset;
      for (std::uint32_t k = bridges.first[slot]; k < bridges.first[slot + 1]; ++k) {
        const Bridge& bridge = bridges.all[bridges.of_slot[k]];
        if (gap > static_cast<float>(margin) + bridge.depth) continue;
        if (!mayTouchBridge(bridge, at, static_cast<double>(tool.radius), margin)) continue;
        // Each bridge once, under its nearest leaf: that one is in the list if the bridge is near.
        const bool is_nearest = std::all_of(bridge.slot.begin(), bridge.slot.end(), [&](std::uint32_t s) {
          if (s == slot) return true;
          const Sphere& leaf = tree.cover_records[s];
          const float reach = gap + tool.radius + leaf.radius;
          const float d2 = static_cast<float>((at - centre(leaf)).squaredNorm());
          return d2 > reach * reach || (d2 == reach * reach && s > slot);
        });
        if (!is_nearest) continue;
        if (workspace.near_bridges.size() == kMostNearBridges) return;
        workspace.near_bridges.push_back({run.object, tool_slot, bridges.of_slot[k]});
      }
    }
  }
}

void addBridgeRows(const Scene& scene, const Configuration& pose, double most_gap, RowSet& out, Workspace& workspace) noexcept {
  workspace.bridge_rows.clear();
  float* const memory = workspace.row_memory.get();
  const std::size_t stride = workspace.row_stride;
  const Eigen::Matrix3d rotation = pose.orientation.toRotationMatrix();
  std::uint32_t row = out.rows.count;
  for (const NearBridge& near : workspace.near_bridges) {
    const CompiledObject& object = scene.objects[near.object];
    const Sphere& tool = scene.tool.cover_records[near.tool_slot];
    const Eigen::Vector3d arm = rotation * centre(tool);
    BridgeContact contact;
    if (!nearestOnBridge(object.tree.bridges.all[near.bridge], arm + (pose.position - object.anchor), contact)) continue;
    const double gap = contact.gap - static_cast<double>(tool.radius);
    if (gap > most_gap || workspace.bridge_rows.size() == kMostBridgeRows) continue;
    const Eigen::Vector3d lever = arm.cross(contact.normal) / scene.angle_length;
    const double weight = 1 / std::sqrt(1 + lever.squaredNorm());
    for (int axis = 0; axis < 3; ++axis) {
      memory[static_cast<std::size_t>(axis) * stride + row] = static_cast<float>(weight * contact.normal[axis]);
      memory[static_cast<std::size_t>(axis + 3) * stride + row] = static_cast<float>(weight * lever[axis]);
    }
    memory[6 * stride + row] = static_cast<float>(-gap * weight);
    memory[7 * stride + row] = static_cast<float>(weight);
    out.smallest_gap = std::min(out.smallest_gap, static_cast<float>(gap));
    workspace.bridge_rows.push_back({near.object, near.tool_slot, near.bridge + 1});
    ++row;
  }
  out.rows.count = row;
  padRows(memory, stride, row);
}

}  // namespace spheretree::runtime
