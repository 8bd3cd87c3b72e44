// SPDX-License-Identifier: Apache-2.0
#include "step/step_parts.h"

#include <algorithm>
#include <chrono>

namespace spheretree::runtime {
namespace {

constexpr int kMaxRelaxations = 16;      // in one QP with conflicting rows
constexpr std::uint32_t kFeltWork = 12;  // cost of 8 felt rows, in groups of rows
constexpr std::uint32_t kHullWork = 16;  // cost of 8 rows of hulls, in rows of balls

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

// The name of row `row`, from its pair in `set`.
RowName nameOf(const PairSet& set, std::uint32_t row, bool is_felt) {
  const PairRun* run = set.runs.data();
  while (row >= run->begin + run->count) ++run;
  return {run->object, set.pairs[row], is_felt, run->of_wall};
}

// Relaxes the rows that contradict each other by the distance that the certificate of the QP proves to be needed: the
// rows of smooth patches alone if it has some. Returns the distance by which all rows were relaxed.
double relax(RowSet& set, const QpAnswer& answer) {
  double sum = 0, weights = 0, felt_weights = 0;
  for (std::size_t k = 0; k < answer.certificate_count; ++k) {
    const double weight = answer.certificate_weight[k] * static_cast<double>(set.weight[answer.certificate[k]]);
    sum += answer.certificate_weight[k] * static_cast<double>(set.b[answer.certificate[k]]);
    (answer.certificate[k] < set.guarded ? weights : felt_weights) += weight;
  }
  const bool felt_alone = felt_weights > 0;
  const double further = std::max(sum / (felt_alone ? felt_weights : weights), 1e-6) * (1 + 1e-6);
  for (std::uint32_t i = felt_alone ? set.guarded : 0; i < set.rows.count; ++i) set.b[i] -= static_cast<float>(further) * set.weight[i];
  return felt_alone ? 0 : further;
}

}  // namespace

Vector6 StepParts::scaledVector(const Displacement& d) const {
  Vector6 y;
  y << d.translation, scene.angle_length * d.rotation;
  return y;
}

Displacement StepParts::displacement(const Vector6& y) const {
  return {Eigen::Vector3d(y[0], y[1], y[2]), Eigen::Vector3d(y[3], y[4], y[5]) / scene.angle_length};
}

std::uint32_t StepParts::costOfRow() const { return scene.hulls.empty() ? 1 : kHullWork; }

PairSet StepParts::search(const Configuration& pose, double margin, PairsOf of) {
  const Stage stage(times_ ? &times_->find : nullptr);
  const std::uint32_t max_work = scene.step_limits.max_work;
  PairSet set = findPairs(pose, margin, of, max_work > result.work ? max_work - result.work : 0, memory);
  if (memory.cutting && of == PairsOf::ContactSurface) memory.cutting->addWalls(pose, margin, set);
  result.work += set.work;
  if (memory.tissue && of == PairsOf::ContactSurface) result.work += memory.tissue->keepNear(pose, margin, set);
  ++result.searches;
  result.pairs = static_cast<std::uint32_t>(set.pairs.size());
  felt_ = {};
  return set;
}

RowSet StepParts::rows(const PairSet& set, const Configuration& pose, RowForm form, const Eigen::Matrix3d& axes) {
  const Stage stage(times_ ? &times_->rows : nullptr);
  result.work += 2 * costOfRow() * groups(set.pairs.size());
  ++result.linearisations;
  result.rows = static_cast<std::uint32_t>(set.pairs.size());
  if (memory.tissue && form == RowForm::TrueDistance) memory.tissue->placePatches(set);
  RowSet out = makeRows(set, pose, form, axes, memory);
  if (memory.cutting && form == RowForm::TrueDistance) result.work += memory.cutting->dropRemoved(set, 0, pose, out);
  if (scene.has_soft) shiftSoft(set, 0, out);
  return out;
}

RowSet StepParts::rows(const PairSet& set, const Configuration& pose) {
  return rows(set, pose, RowForm::TrueDistance, Eigen::Matrix3d::Identity());
}

void StepParts::keepNear(double margin, PairSet& set, RowSet& rows) {
  const Stage stage(times_ ? &times_->find : nullptr);
  result.work += groups(set.pairs.size());
  runtime::keepNear(margin, set, rows, memory);
}

void StepParts::addFelt(const PairSet& set, const Configuration& pose, double margin, RowSet& rows) {
  const Stage stage(times_ ? &times_->rows : nullptr);
  felt_ = feltPairs(set, margin, memory);
  if (!scene.hulls.empty()) result.work += costOfRow() * groups(felt_.pairs.size());  // each is tested first
  addFeltRows(felt_, pose, margin, rows, memory);
  if (memory.cutting) result.work += memory.cutting->dropRemoved(felt_, rows.guarded, pose, rows);
  if (scene.has_soft) shiftSoft(felt_, rows.guarded, rows);
  result.rows = rows.rows.count;
  result.work += kFeltWork * costOfRow() * groups(felt_.pairs.size());
  findActive(set);
}

void StepParts::allowStaying(RowSet& set) {
  for (std::uint32_t i = 0; i < set.rows.count; ++i) set.b[i] = std::min(set.b[i], 0.0f);
}

// Each certificate is a lower bound of the distance (its rows, relaxed by less, still contradict each other). Therefore
// the first bound at which the QP has a solution is the smallest distance.
double StepParts::solve(RowSet& set, const Vector6& target) {
  const Stage stage(times_ ? &times_->qp : nullptr);
  QpAnswer& answer = memory.answer;
  double back = 0;
  for (int round = 0;; ++round) {
    solveQp6(*memory.kernel, set.rows, target, answer);
    result.qp_iterations += answer.iterations;
    result.work += (answer.iterations + 1u) * groups(set.rows.count);
    if (answer.status != QpStatus::Infeasible) break;
    if (round == kMaxRelaxations || !workLeft()) {
      allowStaying(set);  // no time to find the smallest distance: y = 0 now satisfies all rows
      solveQp6(*memory.kernel, set.rows, target, answer);
      back = std::max(back, static_cast<double>(-set.smallest_gap));
      break;
    }
    back += relax(set, answer);
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

RowName StepParts::nameOfRow(const PairSet& set, std::uint32_t row) const {
  const auto guarded = static_cast<std::uint32_t>(set.pairs.size());
  return row < guarded ? nameOf(set, row, false) : nameOf(felt_, row - guarded, true);
}

std::uint32_t StepParts::rowOf(const PairSet& set, const RowName& name) const {
  const PairSet& from = name.is_felt ? felt_ : set;
  for (const PairRun& run : from.runs) {
    if (run.object != name.object || run.of_wall != name.of_wall) continue;
    const auto begin = from.pairs.begin() + run.begin, end = begin + run.count, found = std::find(begin, end, name.pair);
    if (found == end) break;
    return static_cast<std::uint32_t>((found - from.pairs.begin()) + static_cast<std::ptrdiff_t>(name.is_felt ? set.pairs.size() : 0));
  }
  return ~0u;
}

const Eigen::Vector3d* StepParts::rubbingOf(const RowName& name) const {
  for (std::size_t k = 0; k < memory.active_count; ++k)
    if (memory.active_names[k] == name) return &memory.active_rubbing[k];
  return nullptr;
}

void StepParts::keepActive(const PairSet& set) {
  memory.active_count = memory.answer.active_count;
  for (std::size_t k = 0; k < memory.active_count; ++k) {
    memory.active_names[k] = nameOfRow(set, memory.answer.active[k]);
    memory.active_multiplier[k] = memory.answer.multiplier[k];
  }
}

void StepParts::findActive(const PairSet& set) {
  QpAnswer& answer = memory.answer;
  answer.active_count = 0;
  for (std::size_t k = 0; k < memory.active_count; ++k)
    if (const std::uint32_t row = rowOf(set, memory.active_names[k]); row != ~0u) answer.active[answer.active_count++] = row;
}

Eigen::Vector3d armOf(const CompiledScene& scene, const RowSet& rows, std::uint32_t row, const RowName& name, const Eigen::Vector3d& normal,
                      const Eigen::Matrix3d& rotation) {
  if (!rows.along) {
    const Sphere& ball = scene.tool.spheres[name.pair >> 16];
    return rotation * centreOf(ball) - double{ball.radius} * normal;
  }
  // The row has the lever arm x normal, which leaves the part of the arm along the normal open.
  Eigen::Vector3d lever;
  for (int i = 0; i < 3; ++i) lever[i] = double{rows.rows.a[static_cast<std::size_t>(3 + i)][row]};
  return scene.angle_length / double{rows.weight[row]} * normal.cross(lever) + double{rows.along[row]} * normal;
}

}  // namespace spheretree::runtime
