// SPDX-License-Identifier: Apache-2.0
#include "step_parts.h"

#include <algorithm>
#include <chrono>

namespace spheretree::runtime {
namespace {

constexpr int kMostRelaxations = 16;  // of one QP with rows that conflict

class Stage {
 public:
  explicit Stage(std::uint64_t* total) : total_(total), start_(total ? now() : 0) {}
  ~Stage() {
    if (total_) *total_ += now() - start_;
  }
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

 private:
  static std::uint64_t now() {
    return static_cast<std::uint64_t>(
        std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch()).count());
  }
  std::uint64_t* total_;
  std::uint64_t start_;
};

std::uint32_t groups(std::size_t rows) { return static_cast<std::uint32_t>((rows + 7) / 8); }

PairName nameOf(const PairSet& set, std::uint32_t row) {
  const PairRun* run = set.runs.data();
  while (row >= run->begin + run->count) ++run;
  return {run->object, set.pairs[row], false};
}

}  // namespace

PairSet StepParts::search(const Configuration& pose, double margin, bool exact) {
  const Stage stage(times_ ? &times_->find : nullptr);
  const std::uint32_t most = scene.step_limits.max_work;
  const PairSet set = findPairs(scene, pose, margin, exact, most > result.work ? most - result.work : 0, workspace);
  result.work += set.work;
  ++result.searches;
  result.pairs = static_cast<std::uint32_t>(set.pairs.size());
  return set;
}

void StepParts::searchBridges(const Configuration& pose, double margin) {
  bridges_ = {};
  if (scene.bridges.empty()) return;
  const Stage stage(times_ ? &times_->find : nullptr);
  const std::uint32_t most = scene.step_limits.max_work;
  bridges_ = findNearBridges(scene, pose, margin, most > result.work ? most - result.work : 0, workspace);
  result.work += bridges_.work;
}

void StepParts::narrowTo(double margin, const RowSet& rows, const Configuration& pose, PairSet& set) {
  const Stage stage(times_ ? &times_->find : nullptr);
  result.work += groups(set.pairs.size()) + 3 * groups(bridges_.pairs.size());
  narrow(scene, rows, pose, margin, set, bridges_, workspace);
  findActive(set);
}

RowSet StepParts::rows(const PairSet& set, const Configuration& pose, RowForm form, const Eigen::Matrix3d& axes) {
  const Stage stage(times_ ? &times_->rows : nullptr);
  result.work += 2 * groups(set.pairs.size());
  ++result.linearisations;
  result.rows = static_cast<std::uint32_t>(set.pairs.size());
  return makeRows(scene, set, pose, form, axes, workspace);
}

RowSet StepParts::allRows(const PairSet& set, const Configuration& pose, double margin) {
  RowSet out = rows(set, pose);
  const Stage stage(times_ ? &times_->rows : nullptr);
  addBridgeRows(scene, bridges_, pose, margin, out, workspace);
  result.rows = out.rows.count;
  result.work += 3 * groups(bridges_.pairs.size());
  return out;
}

void StepParts::allowStaying(const RowSet& set) {
  float* const b = const_cast<float*>(set.rows.b);  // the workspace's own row memory
  for (std::uint32_t i = 0; i < set.rows.count; ++i) b[i] = std::min(b[i], 0.0f);
}

// Each certificate is a lower bound of the distance (its rows, moved back by less, still contradict each other), and the first bound at
// which the QP has an answer is therefore the least.
double StepParts::solve(const RowSet& set, const Vector6& target) {
  const Stage stage(times_ ? &times_->qp : nullptr);
  QpAnswer& answer = workspace.answer;
  double back = 0;
  for (int round = 0;; ++round) {
    solveQp6(*workspace.kernel, set.rows, target, answer);
    result.qp_iterations += answer.iterations;
    result.work += (answer.iterations + 1u) * groups(set.rows.count);
    if (answer.status != QpStatus::Infeasible) break;
    float* const b = const_cast<float*>(set.rows.b);  // the workspace's own row memory
    if (round == kMostRelaxations || !workLeft()) {
      allowStaying(set);  // no time to find the least: now y = 0 satisfies all
      solveQp6(*workspace.kernel, set.rows, target, answer);
      back = std::max(back, static_cast<double>(-set.smallest_gap));
      break;
    }
    double sum = 0, weights = 0, bridge_weights = 0;
    for (std::size_t k = 0; k < answer.certificate_count; ++k) {
      const double weight = answer.certificate_weight[k] * static_cast<double>(set.weight[answer.certificate[k]]);
      sum += answer.certificate_weight[k] * static_cast<double>(b[answer.certificate[k]]);
      (answer.certificate[k] < set.leaf_count ? weights : bridge_weights) += weight;
    }
    const bool bridges_alone = bridge_weights > 0;
    const double further = std::max(sum / (bridges_alone ? bridge_weights : weights), 1e-6) * (1 + 1e-6);
    for (std::uint32_t i = bridges_alone ? set.leaf_count : 0; i < set.rows.count; ++i) b[i] -= static_cast<float>(further) * set.weight[i];
    if (!bridges_alone) back += further;
  }
  if (answer.status == QpStatus::IterationLimit) {
    result.faults |= kQpStopped;
    answer.y.setZero();
    answer.active_count = 0;
  }
  if (back > kGapTolerance) result.faults |= kRowsConflict;
  result.active = answer.active_count;
  return back;
}

void StepParts::keepActive(const PairSet& set) {
  workspace.active_count = workspace.answer.active_count;
  for (std::size_t k = 0; k < workspace.active_count; ++k) {
    const std::uint32_t row = workspace.answer.active[k];
    const bool is_bridge = row >= set.pairs.size();
    workspace.active_names[k] = is_bridge ? nameOf(bridges_, row - static_cast<std::uint32_t>(set.pairs.size())) : nameOf(set, row);
    workspace.active_names[k].is_bridge = is_bridge;
  }
}

void StepParts::findActive(const PairSet& set) {
  QpAnswer& answer = workspace.answer;
  answer.active_count = 0;
  for (std::size_t k = 0; k < workspace.active_count; ++k) {
    const PairName& name = workspace.active_names[k];
    const PairSet& from = name.is_bridge ? bridges_ : set;
    for (const PairRun& run : from.runs) {
      if (run.object != name.object) continue;
      const auto begin = from.pairs.begin() + run.begin, end = begin + run.count, found = std::find(begin, end, name.pair);
      if (found != end)
        answer.active[answer.active_count++] =
            static_cast<std::uint32_t>((found - from.pairs.begin()) + static_cast<std::ptrdiff_t>(name.is_bridge ? set.pairs.size() : 0));
      break;
    }
  }
}

}  // namespace spheretree::runtime
