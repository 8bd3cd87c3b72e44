// SPDX-License-Identifier: Apache-2.0
#include "spheretree/runtime/contact.h"

#include <algorithm>
#include <limits>

#include "kernel.h"
#include "spheretree/runtime/workspace.h"

namespace spheretree::runtime {

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
  // The rows past the end are in no one's way.
  for (std::size_t k = 0; k < 8; ++k) std::fill_n(memory + k * workspace.row_stride + out.rows.count, 8, k == 6 ? -1e30f : 0.0f);
  return out;
}

}  // namespace spheretree::runtime
