// SPDX-License-Identifier: Apache-2.0
#include "rows/rows.h"

#include <algorithm>
#include <limits>

#include "state/step_memory.h"

namespace spheretree::runtime {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Indices of the arrays of a set of rows in StepMemory::row_memory; those before kB are the coefficients.
constexpr std::size_t kB = 6;
constexpr std::size_t kWeight = 7;
constexpr std::size_t kFeltWay = 8;
constexpr std::size_t kAlong = 9;

// Makes the padding rows always satisfied.
void padRows(StepMemory& memory, std::uint32_t count) {
  for (std::size_t k = 0; k < kRowArrays; ++k) std::fill_n(memory.rowArray(k) + count, 8, k == kB ? -1e30f : 0.0f);
}

// Requests for the runs of a set of pairs, for one pose of the tool.
class Requests {
 public:
  Requests(const Configuration& pose, RowForm form, StepMemory& memory) : memory_(memory) {
    const Eigen::Matrix3d rotation = pose.orientation.normalized().toRotationMatrix();
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) rotation_[3 * r + c] = rotation(r, c);
      position_[r] = pose.position[r];
    }
    const CompiledHulls& hulls = memory.scene.hulls;
    has_hulls_ = form == RowForm::TrueDistance && !hulls.empty();
    request_.tool = has_hulls_ ? hulls.ball.data() : memory.scene.tool.spheres.data();
    if (has_hulls_) request_.hulls = spansOf(hulls);
    request_.inverse_angle_length = static_cast<float>(1 / memory.scene.angle_length);
    request_.squared = form == RowForm::SquaredDistance;
    request_.max_gap = 0;
  }

  RowRequest& request() { return request_; }

  // The request for `run` of `pairs`; the rows are stored from `first_row` on.
  RowRequest& of(const ObjectView& view, const PairRun& run, const std::uint32_t* pairs, std::uint32_t first_row) {
    request_.pose = relativePose(view, rotation_, position_);
    for (int k = 0; k < 9; ++k) request_.to_world[k] = static_cast<float>(view.to_world[k]);
    request_.pairs = pairs + run.begin;
    request_.count = run.count;
    request_.bound = view.bound;
    request_.object = view.spheres;
    request_.allowance = view.allowance;
    request_.behind = view.behind;
    request_.in_front = view.in_front;
    request_.patches = view.patches;
    request_.items = view.items;
    request_.points = view.points;
    request_.step = view.step;
    for (std::size_t k = 0; k < 6; ++k) request_.a[k] = memory_.rowArray(k) + first_row;
    request_.b = memory_.rowArray(kB) + first_row;
    request_.weight = memory_.rowArray(kWeight) + first_row;
    request_.felt_way = memory_.rowArray(kFeltWay) + first_row;
    request_.along = has_hulls_ ? memory_.rowArray(kAlong) + first_row : nullptr;
    return request_;
  }

 private:
  StepMemory& memory_;
  bool has_hulls_;
  double rotation_[9], position_[3];
  RowRequest request_{};
};

}  // namespace

RowSet makeRows(const PairSet& set, const Configuration& pose, RowForm form, const Eigen::Matrix3d& axes, StepMemory& memory) noexcept {
  RowSet out;
  for (std::size_t k = 0; k < 6; ++k) out.rows.a[k] = memory.rowArray(k);
  out.rows.b = out.b = memory.rowArray(kB);
  out.weight = memory.rowArray(kWeight);
  if (form == RowForm::TrueDistance && !memory.scene.hulls.empty()) out.along = memory.rowArray(kAlong);
  out.rows.count = out.guarded = static_cast<std::uint32_t>(set.pairs.size());
  out.smallest_gap = out.smallest_felt_gap = kInfinity;
  if (set.pairs.empty()) return out;

  Requests requests(pose, form, memory);
  RowRequest& common = requests.request();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) common.axes[3 * r + c] = static_cast<float>(axes(c, r));
  for (const PairRun& run : set.runs) {
    const ObjectView& view = common.squared ? memory.leaf_views[run.object] : memory.views[run.object];
    RowRequest& request = requests.of(view, run, set.pairs.data(), run.begin);
    if (run.of_wall) request.object = memory.cutting->walls();
    const bool on_triangles = view.patches != nullptr && !set.coarse && !run.of_wall;
    if (request.in_front && on_triangles) memory.tissue->findFront(request);
    out.smallest_gap = std::min(out.smallest_gap, on_triangles ? memory.kernel->flatRows(request) : memory.kernel->sphereRows(request));
  }
  padRows(memory, out.rows.count);
  return out;
}

namespace {

// Guarded rows with a larger gap belong to nothing within `margin`. The patch may be nearer than the flat triangle by
// the tolerance, which is at most the triangle's allowance. Tissue may come nearer by its motion, and may have moved
// away by as much before.
float reachOf(std::uint32_t object, double margin, const StepMemory& memory) {
  const auto largest = static_cast<float>(margin * (1 + 1e-6));
  return largest + 2 * (memory.views[object].allowance + memory.views[object].motion);
}

}  // namespace

void keepNear(double margin, PairSet& pairs, RowSet& rows, StepMemory& memory) noexcept {
  const float* const felt_way = memory.rowArray(kFeltWay);
  std::uint32_t count = 0;
  for (PairRun& run : memory.runs) {
    const float largest = reachOf(run.object, margin, memory);
    const std::uint32_t begin = count;
    for (std::uint32_t i = run.begin; i < run.begin + run.count; ++i) {
      // The felt row of a hull may be of another ball than the guarded one.
      if (-rows.b[i] > largest * rows.weight[i] && !(rows.along && felt_way[i] <= largest)) continue;
      memory.pairs[count] = memory.pairs[i];
      for (std::size_t k = 0; k < kAlong; ++k) memory.rowArray(k)[count] = memory.rowArray(k)[i];
      if (rows.along) memory.rowArray(kAlong)[count] = memory.rowArray(kAlong)[i];
      ++count;
    }
    run.begin = begin;
    run.count = count - begin;
  }
  std::erase_if(memory.runs, [](const PairRun& run) { return run.count == 0; });
  pairs.pairs = {memory.pairs.data(), count};
  pairs.runs = memory.runs;
  rows.rows.count = rows.guarded = count;
  padRows(memory, count);
}

PairSet feltPairs(const PairSet& set, double way, StepMemory& memory) noexcept {
  memory.felt_runs.clear();
  const auto longest = static_cast<float>(way * (1 + 1e-6));
  const float* const felt_way = memory.rowArray(kFeltWay);
  std::uint32_t count = 0;
  for (const PairRun& run : set.runs) {
    if (!memory.feelsSkin(run.object) || run.of_wall) continue;
    const std::uint32_t begin = count;
    for (std::uint32_t i = run.begin; i < run.begin + run.count; ++i)
      if (felt_way[i] <= longest) memory.felt_pairs[count++] = set.pairs[i];
    if (count > begin) memory.felt_runs.push_back({run.object, begin, count - begin});
  }
  PairSet out;
  out.pairs = {memory.felt_pairs.data(), count};
  out.runs = memory.felt_runs;
  return out;
}

void addFeltRows(PairSet& felt, const Configuration& pose, double max_gap, RowSet& rows, StepMemory& memory) noexcept {
  if (felt.pairs.empty()) return;
  Requests requests(pose, RowForm::TrueDistance, memory);
  requests.request().max_gap = static_cast<float>(max_gap);
  std::uint32_t count = 0;
  for (PairRun& run : memory.felt_runs) {
    if (!memory.scene.hulls.empty()) {
      std::uint32_t* const pairs = memory.felt_pairs.data() + run.begin;
      run.count = memory.kernel->keepResting(requests.of(memory.views[run.object], run, felt.pairs.data(), rows.rows.count), pairs);
      std::copy_n(pairs, run.count, memory.felt_pairs.data() + count);
      run.begin = count;
    }
    count += run.count;
    const RowRequest& request = requests.of(memory.views[run.object], run, felt.pairs.data(), rows.rows.count);
    const float gap = memory.isTissue(run.object) ? memory.tissue->patchRows(request) : memory.kernel->feltRows(request);
    rows.smallest_felt_gap = std::min(rows.smallest_felt_gap, gap);
    rows.rows.count += run.count;
  }
  felt.pairs = felt.pairs.first(count);
  padRows(memory, rows.rows.count);
}

}  // namespace spheretree::runtime
