// SPDX-License-Identifier: Apache-2.0
#include "rows.h"

#include <algorithm>
#include <limits>

#include "step_memory.h"

namespace spheretree::runtime {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// The rows past the end are in no one's way.
void padRows(float* memory, std::size_t stride, std::uint32_t count) {
  for (std::size_t k = 0; k < 8; ++k) std::fill_n(memory + k * stride + count, 8, k == 6 ? -1e30f : 0.0f);
}

// Requests for the runs of a set of pairs, tool at one pose.
class Requests {
 public:
  Requests(const Configuration& pose, StepMemory& memory) : memory_(memory) {
    const Eigen::Matrix3d rotation = pose.orientation.normalized().toRotationMatrix();
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) rotation_[3 * r + c] = rotation(r, c);
      position_[r] = pose.position[r];
    }
    request_.tool = memory.scene.tool.spheres.data();
    request_.inverse_angle_length = static_cast<float>(1 / memory.scene.angle_length);
    request_.squared = false;
    request_.most_gap = 0;
  }

  RowRequest& request() { return request_; }

  // For `run` of `pairs`; the rows go to `first_row` and on.
  const RowRequest& of(const ObjectView& view, const PairRun& run, const std::uint32_t* pairs, std::uint32_t first_row) {
    request_.pose = relativePose(view, rotation_, position_);
    for (int k = 0; k < 9; ++k) request_.to_world[k] = static_cast<float>(view.to_world[k]);
    request_.pairs = pairs + run.begin;
    request_.count = run.count;
    request_.bound = view.bound;
    request_.object = view.spheres;
    request_.allowance = view.allowance;
    request_.patches = view.patches;
    request_.items = view.items;
    float* const first = memory_.row_memory.get() + first_row;
    for (std::size_t k = 0; k < 6; ++k) request_.a[k] = first + k * memory_.row_stride;
    request_.b = first + 6 * memory_.row_stride;
    request_.weight = first + 7 * memory_.row_stride;
    return request_;
  }

 private:
  StepMemory& memory_;
  double rotation_[9], position_[3];
  RowRequest request_{};
};

}  // namespace

RowSet makeRows(const PairSet& set, const Configuration& pose, RowForm form, const Eigen::Matrix3d& axes, StepMemory& memory) noexcept {
  RowSet out;
  float* const rows = memory.row_memory.get();
  for (std::size_t k = 0; k < 6; ++k) out.rows.a[k] = rows + k * memory.row_stride;
  out.b = rows + 6 * memory.row_stride;
  out.rows.b = out.b;
  out.weight = rows + 7 * memory.row_stride;
  out.rows.count = out.guarded = static_cast<std::uint32_t>(set.pairs.size());
  out.smallest_gap = out.smallest_felt_gap = kInfinity;
  if (set.pairs.empty()) return out;

  Requests requests(pose, memory);
  RowRequest& common = requests.request();
  common.squared = form == RowForm::SquaredDistance;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) common.axes[3 * r + c] = static_cast<float>(axes(c, r));
  for (const PairRun& run : set.runs) {
    const ObjectView& view = common.squared ? memory.leaf_views[run.object] : memory.views[run.object];
    const RowRequest& request = requests.of(view, run, set.pairs.data(), run.begin);
    const bool on_triangles = view.patches != nullptr && !set.coarse;
    out.smallest_gap = std::min(out.smallest_gap, on_triangles ? memory.kernel->flatRows(request) : memory.kernel->sphereRows(request));
  }
  padRows(rows, memory.row_stride, out.rows.count);
  return out;
}

namespace {

// Guarded rows with a larger gap are of nothing that is within `margin`. The patch may be nearer than the flat triangle
// by the tolerance, and that is what the triangle gives way, at most.
float reachOf(std::uint32_t object, double margin, const StepMemory& memory) {
  const auto most = static_cast<float>(margin * (1 + 1e-6));
  return memory.feelsSkin(object) ? most + 2 * memory.scene.shapeOf(object).skin.tolerance : most;
}

}  // namespace

void keepNear(double margin, PairSet& pairs, RowSet& rows, StepMemory& memory) noexcept {
  float* const first = memory.row_memory.get();
  std::uint32_t count = 0;
  for (PairRun& run : memory.runs) {
    const float most = reachOf(run.object, margin, memory);
    const std::uint32_t begin = count;
    for (std::uint32_t i = run.begin; i < run.begin + run.count; ++i) {
      if (-rows.b[i] > most * rows.weight[i]) continue;
      memory.pairs[count] = memory.pairs[i];
      for (std::size_t k = 0; k < 8; ++k) first[k * memory.row_stride + count] = first[k * memory.row_stride + i];
      ++count;
    }
    run.begin = begin;
    run.count = count - begin;
  }
  std::erase_if(memory.runs, [](const PairRun& run) { return run.count == 0; });
  pairs.pairs = {memory.pairs.data(), count};
  pairs.runs = memory.runs;
  rows.rows.count = rows.guarded = count;
  padRows(first, memory.row_stride, count);
}

PairSet feltPairs(const PairSet& set, const RowSet& rows, double most_gap, StepMemory& memory) noexcept {
  memory.felt_runs.clear();
  std::uint32_t count = 0;
  for (const PairRun& run : set.runs) {
    const ObjectView& view = memory.views[run.object];
    if (view.patches == nullptr) continue;
    const float most = reachOf(run.object, most_gap, memory);
    const std::uint32_t begin = count;
    for (std::uint32_t i = run.begin; i < run.begin + run.count; ++i)
      if (-rows.b[i] <= most * rows.weight[i] && (view.patches[view.items[set.pairs[i] & 0xffff]].flags & kCurved) != 0)
        memory.felt_pairs[count++] = set.pairs[i];
    if (count > begin) memory.felt_runs.push_back({run.object, begin, count - begin});
  }
  PairSet out;
  out.pairs = {memory.felt_pairs.data(), count};
  out.runs = memory.felt_runs;
  return out;
}

void addFeltRows(const PairSet& felt, const Configuration& pose, double most_gap, RowSet& rows, StepMemory& memory) noexcept {
  if (felt.pairs.empty()) return;
  Requests requests(pose, memory);
  requests.request().most_gap = static_cast<float>(most_gap);
  for (const PairRun& run : felt.runs) {
    const RowRequest& request = requests.of(memory.views[run.object], run, felt.pairs.data(), rows.rows.count);
    rows.smallest_felt_gap = std::min(rows.smallest_felt_gap, memory.kernel->feltRows(request));
    rows.rows.count += run.count;
  }
  padRows(memory.row_memory.get(), memory.row_stride, rows.rows.count);
}

}  // namespace spheretree::runtime
