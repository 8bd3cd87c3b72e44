// SPDX-License-Identifier: Apache-2.0
// The contact problem of a piece if contacts have friction or objects yield: docs/runtime.md, Friction and Objects that
// give way.
#include <algorithm>
#include <cmath>

#include "contact/contact_forces.h"
#include "step/contact_rows.h"
#include "step/step_parts.h"

namespace spheretree::runtime {
namespace {

constexpr int kMaxScans = 36;             // rows that enter
constexpr int kMaxNewRows = 4;            // that join the rows of the last piece before the QP without friction is asked
constexpr double kForceTolerance = 1e-6;  // of the residuals: gaps are floats and not known more accurately [mm, scaled]
constexpr float kOutOfTheWay = -1e30f;

class ContactSolver {
 public:
  ContactSolver(StepParts& parts, const PairSet& pairs, RowSet& rows, const Vector6& target, const CarriedPiece* carried)
      : parts_(parts),
        scene_(parts.scene),
        memory_(parts.memory),
        pairs_(pairs),
        rows_(rows),
        target_(target),
        carried_(carried),
        tissue_(parts.memory.tissue ? &parts.memory.tissue->contacts() : nullptr),
        problem_(*parts.memory.contact_problem),
        in_(parts, pairs, rows, carried, tissue_) {}

  double run();

 private:
  bool isSoft(std::uint32_t object) const { return scene_.objects[object].softness > 0 || memory_.isTissue(object); }
  template <class Work>
  void forSoftRows(const Work& work);
  [[gnu::noinline]] void restoreSoft();
  [[gnu::noinline]] void start();
  bool holdsAsBefore();
  void predict();
  bool takeInViolated();
  [[gnu::noinline]] void solve();
  void keep();

  StepParts& parts_;
  const CompiledScene& scene_;
  StepMemory& memory_;
  const PairSet& pairs_;
  RowSet& rows_;
  const Vector6 target_;
  const CarriedPiece* carried_;
  TissueContacts* const tissue_;
  ContactProblem& problem_;
  ContactRows in_;
};

template <class Work>
void ContactSolver::forSoftRows(const Work& work) {
  const auto of = [&](const PairSet& set, std::uint32_t first) {
    for (const PairRun& run : set.runs)
      if (isSoft(run.object))
        for (std::uint32_t i = first + run.begin; i < first + run.begin + run.count; ++i) work(run.object, i);
  };
  of(pairs_, 0);
  of(parts_.felt(), rows_.guarded);
}

void ContactSolver::restoreSoft() {
  if (scene_.has_soft) forSoftRows([&](std::uint32_t, std::uint32_t i) { rows_.b[i] = memory_.soft_b[i]; });
}

// Adds the previously active rows, with their multipliers.
void ContactSolver::start() {
  in_.clear();
  problem_.target = target_;
  problem_.tolerance = kForceTolerance;
  for (std::size_t k = 0; k < memory_.active_count; ++k) {
    const std::uint32_t row = parts_.rowOf(pairs_, memory_.active_names[k]);
    if (row != ~0u) in_.takeIn(row, memory_.active_multiplier[k]);
  }
}

// Whether the previous contacts still hold the tool, and no other: then no prediction is needed.
bool ContactSolver::holdsAsBefore() {
  if (carried_ || scene_.has_soft || !parts_.rubs || memory_.active_count == 0) return false;
  start();
  for (int scan = 0; scan < kMaxNewRows; ++scan) {
    solve();
    if (!problem_.converged) return false;
    if (!takeInViolated()) return true;
  }
  return false;
}

// Adds the active rows of the QP without friction, with the multipliers that it predicts.
void ContactSolver::predict() {
  const QpAnswer& predicted = memory_.answer;
  for (std::size_t k = 0; k < predicted.active_count; ++k)
    in_.takeIn(predicted.active[k], carried_ ? 0 : predicted.multiplier[k],
               memory_.isTissue(parts_.nameOfRow(pairs_, predicted.active[k]).object));
}

// Adds the row that the solution violates most; false if there is none, or no space for it.
bool ContactSolver::takeInViolated() {
  if (tissue_) tissue_->predict(problem_);
  if (scene_.has_soft)
    forSoftRows([&](std::uint32_t object, std::uint32_t i) {
      bool is_at_stop = false;
      if (memory_.isTissue(object)) {
        rows_.b[i] = tissue_->predictedBound(i, is_at_stop);
        return;
      }
      rows_.b[i] = memory_.soft_b[i] + static_cast<float>(memory_.give[object] - in_.giveOf(object)) * rows_.weight[i];
    });
  float y[6];
  double largest = 0;
  for (std::size_t k = 0; k < 6; ++k) {
    y[k] = static_cast<float>(problem_.y[static_cast<Eigen::Index>(k)]);
    largest = std::max(largest, std::abs(problem_.y[static_cast<Eigen::Index>(k)]));
  }
  const WorstRow worst = memory_.kernel->worstRow(rows_.rows.a.data(), rows_.rows.b, rows_.rows.count, y);
  parts_.result.work += (rows_.rows.count + 7) / 8;
  bool is_violated = static_cast<double>(worst.slack) < -(kQpTolerance + 1e-6 * largest), is_stop = false;
  if (tissue_ && is_violated) {
    const std::uint32_t object = parts_.nameOfRow(pairs_, worst.row).object;
    if (memory_.isTissue(object)) (void)tissue_->predictedBound(worst.row, is_stop);
  }
  is_violated = is_violated && in_.placeOf(worst.row, is_stop) < 0;
  restoreSoft();
  return is_violated && in_.takeIn(worst.row, 0, is_stop) >= 0;
}

void ContactSolver::solve() {
  const std::uint32_t max_work = scene_.step_limits.max_work / 2;  // beyond which a hard problem takes its best forces
  parts_.result.work += solveForces(problem_, tissue_ ? &tissue_->compliance() : nullptr, max_work);
  parts_.result.qp_iterations += static_cast<std::uint32_t>(problem_.iterations);
}

void ContactSolver::keep() {
  in_.keep();
  parts_.result.active = memory_.answer.active_count;
  parts_.result.unsolved += problem_.converged ? 0 : 1;
  if (tissue_) tissue_->press(problem_, {memory_.answer.active.data(), memory_.answer.active_count});
}

double ContactSolver::run() {
  if (tissue_) tissue_->begin(pairs_, parts_.felt(), rows_, parts_.contact_pose, carried_ != nullptr);
  if (scene_.has_soft)
    forSoftRows([&](std::uint32_t object, std::uint32_t i) {
      memory_.soft_b[i] = rows_.b[i];
      rows_.b[i] = memory_.isTissue(object) ? tissue_->stop(i) : kOutOfTheWay;
    });
  double back = 0;
  if (holdsAsBefore()) {
    memory_.answer.status = QpStatus::Optimal;
  } else {
    back = parts_.solve(rows_, target_);
    restoreSoft();
    if (memory_.answer.status != QpStatus::Optimal) return back;
    start();
    predict();
    for (int scan = 0; scan < kMaxScans; ++scan) {
      solve();
      if (!problem_.converged || !takeInViolated()) break;
    }
  }
  keep();
  return back;
}

}  // namespace

double StepParts::solveContact(const PairSet& pairs, RowSet& rows, const Vector6& target, const Configuration& at,
                               const CarriedPiece* carried) {
  contact_pose = at;
  return ContactSolver(*this, pairs, rows, target, carried).run();
}

void StepParts::giveWay(double share) {
  for (std::size_t i = 0; i < memory.give.size(); ++i)
    memory.give[i] = memory.give_from[i] + share * (memory.give_to[i] - memory.give_from[i]);
  if (memory.tissue) memory.tissue->giveWay(share);
}

void StepParts::letGo() {
  std::fill(memory.give.begin(), memory.give.end(), 0.0);
  if (memory.tissue) memory.tissue->letGo();
}

void StepParts::shiftSoft(const PairSet& set, std::uint32_t first, RowSet& rows) const {
  for (const PairRun& run : set.runs) {
    const auto give = static_cast<float>(memory.give[run.object]);
    if (!(give > 0)) continue;
    for (std::uint32_t i = first + run.begin; i < first + run.begin + run.count; ++i) rows.b[i] -= give * rows.weight[i];
  }
  float smallest = std::numeric_limits<float>::infinity();
  for (std::uint32_t i = first; i < first + static_cast<std::uint32_t>(set.pairs.size()); ++i)
    if (rows.weight[i] > 0) smallest = std::min(smallest, -rows.b[i] / rows.weight[i]);
  (first == 0 ? rows.smallest_gap : rows.smallest_felt_gap) = smallest;
}

}  // namespace spheretree::runtime
