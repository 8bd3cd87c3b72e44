// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/batch/budget_search.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "pipeline/batch/error_curve.h"
#include "program_end.h"

namespace spheretree::pipeline {
namespace {

using builder::BuilderKind;
using builder::Quality;

constexpr int kSearchRounds = 3;          // with quick trees
constexpr int kFinalRounds = 3;           // with the final trees
constexpr std::size_t kFirstLeaves = 64;  // for each object in the first round
constexpr double kSameLeaves = 0.04;      // a smaller relative change does not justify another quick build
constexpr double kMoreIfQuick = 1.1;      // leaves of quick trees as a multiple of those of better trees with the same error
constexpr double kWellSpent = 0.95;       // share of the budget that is enough
constexpr double kMinStep = 0.005;        // relative change of the error between two rounds
constexpr double kAim = 0.995;            // share of the budget that is requested, so that the trees stay within it
constexpr std::size_t kRoomForMore = 4;   // the levels of a tree hold this multiple of the leaves that are expected

std::size_t leavesOf(const BatchItem& item) { return item.result.figures.leaves; }

/// The error that more leaves reduce: the proven overhang as a multiple of its tolerance, or in mm if the scene has
/// none.
double errorOf(const BatchItem& item) {
  const TreeFigures& figures = item.result.figures;
  return figures.isGraded() ? item.job.scale * figures.ratio->min_met_mm.value() / *figures.min_tolerance_mm : figures.ratio->ratio;
}

class BudgetSearch {
 public:
  BudgetSearch(const Budget& budget, const std::vector<BatchItem>& items, ToolPaths paths, const BatchContext& context)
      : budget_(budget), paths_(std::move(paths)), random_(paths_.empty()), context_(context), source_(items) {
    double common = 0;  // without a tolerance of its own, an object uses the largest tolerance of the scene
    for (const BatchItem& item : items) common = std::max(common, item.job.settings.tolerance_mm);
    for (std::size_t i = 0; i < items.size(); ++i) {
      if (items[i].hasTree()) fixed_ += leavesOf(items[i]);
      if (items[i].status != ItemStatus::Waiting) continue;
      builder::BuildSettings& settings = source_[i].job.settings;
      if (!settings.searches())
        throw tool::UsageError(items[i].source->name + ": a published method makes as many leaves as it makes, and " +
                               std::string(builder::name(settings.builder)) + " is one. Add \"search\": true, or build without a budget.");
      if (!(settings.tolerance_mm > 0)) settings.tolerance_mm = common;
      waiting_.push_back(i);
      max_.push_back(maxLeaves(context.scene, items[i]));
    }
    if (!budget.is_time && budget.amount < static_cast<double>(fixed_ + waiting_.size()))
      throw tool::UsageError("a budget of " + std::to_string(static_cast<std::size_t>(budget.amount)) +
                             " leaves is less than one for each of " + std::to_string(waiting_.size()) + " trees to build" +
                             (fixed_ > 0 ? " and " + std::to_string(fixed_) + " in trees given by the scene" : "") + ". Allow more.");
    curves_.resize(waiting_.size());
    aim_ = budget.is_time ? kFirstLeaves * waiting_.size() + fixed_ : static_cast<std::size_t>(kAim * budget.amount);
  }

  /// Returns the best round. The errors of quick trees tell at which common error the trees spend the budget. The final
  /// trees are built for this error, as for a tolerance; their number of leaves corrects it.
  std::vector<BatchItem> run() {
    if (waiting_.empty()) return source_;
    const std::size_t each = std::max<std::size_t>(1, (aim_ - std::min(aim_, fixed_)) / waiting_.size());
    shares_.leaves.assign(waiting_.size(), std::min(kFirstLeaves, each));
    for (int round = 0; round < kSearchRounds && !waiting_.empty(); ++round) {
      build(Aim::Leaves, true, round);
      redistribute();
    }
    double share = leavesOfQuickTrees();
    bool fits = false;  // the last round
    for (int round = 0; round < kFinalRounds && !waiting_.empty(); ++round, share = 1) {
      const double last = scale_;
      shares_ = shareOf(static_cast<std::size_t>(share * static_cast<double>(aim_)));
      scale_ = shares_.error;
      if (round > 0) scale_ = fits ? std::min(scale_, (1 - kMinStep) * last) : std::max(scale_, (1 + kMinStep) * last);
      const Round built = build(Aim::Error, false, round);
      keep(built);
      fits = built.fits;
      if (fits && (built.spent > kWellSpent * budget_.amount || shares_.leaves == max_)) break;
    }
    if (!best_.fits && !waiting_.empty()) {
      shares_ = shareOf(aim_);
      keep(build(Aim::Leaves, false, kFinalRounds));
    }
    for (BatchItem& item : best_.items)
      if (built_.count(item.key) > 0) item.status = ItemStatus::Built;
    return std::move(best_.items);
  }

  BudgetResult result() const {
    return {.budget = budget_,
            .spent = best_.spent,
            .met = best_.fits,
            .worst_ratio = best_.errors.empty() ? std::nullopt : std::optional(best_.errors.front()),
            .common_ratio = best_.common,
            .has_recorded_paths = !random_,
            .rounds = rounds_};
  }

 private:
  struct Round {
    std::vector<BatchItem> items;
    std::vector<double> errors;  // in descending order
    double common = 0;           // the error that all trees were to keep
    double spent = 0;
    bool fits = false;
  };

  /// What the trees of a round are built for.
  enum class Aim { Leaves, Error };

  void keep(const Round& built) {
    const bool is_better = built.fits != best_.fits ? built.fits : built.fits ? built.errors < best_.errors : built.spent < best_.spent;
    if (best_.items.empty() || is_better) best_ = built;
  }

  LeafShares shareOf(std::size_t leaves) const { return shareLeaves(curves_, max_, std::max(leaves, fixed_ + waiting_.size()) - fixed_); }

  /// Distributes the leaves again. Small changes are not made.
  void redistribute() {
    LeafShares shares = shareOf(aim_);
    for (std::size_t k = 0; k < waiting_.size(); ++k) {
      const auto now = static_cast<double>(shares_.leaves[k]), then = static_cast<double>(shares.leaves[k]);
      if (std::abs(then - now) <= std::max(1.0, kSameLeaves * now)) shares.leaves[k] = shares_.leaves[k];
    }
    shares_ = std::move(shares);
    scale_ = shares_.error;
  }

  /// Leaves of quick trees as a multiple of those of the final trees, for the same error.
  double leavesOfQuickTrees() const {
    double sum = 0;
    for (const std::size_t i : waiting_) sum += source_[i].job.settings.quality == Quality::Quick ? 1 : kMoreIfQuick;
    return waiting_.empty() ? 1 : sum / static_cast<double>(waiting_.size());
  }

  /// Whether tree `k` is built for a number of leaves: all that it may have, if these do not reach the error.
  bool isForLeaves(Aim aim, std::size_t k) const { return aim == Aim::Leaves || shares_.leaves[k] >= max_[k]; }

  void prepare(TreeJob& job, std::size_t k, Aim aim, bool search) const {
    builder::BuildSettings& settings = job.settings;
    if (isForLeaves(aim, k)) {
      limitLeaves(settings, shares_.leaves[k]);
      if (job.work && settings.tolerance_mm > 0) job.scale = scale_;
    } else {
      limitLeaves(settings, std::min(max_[k], kRoomForMore * shares_.leaves[k]));
      settings.max_leaves = 0;
      job.is_for_error = true;
      job.scale = scale_;
    }
    if (search) {
      settings.quality = Quality::Quick;
      settings.skin = settings.skin && budget_.is_time;  // only the time of a step depends on it
    }
  }

  Round build(Aim aim, bool search, int number) {
    Round round;
    round.common = scale_;
    round.items = source_;
    for (std::size_t k = 0; k < waiting_.size(); ++k) prepare(round.items[waiting_[k]].job, k, aim, search);
    buildItems(round.items, context_, "budget, " + std::string(search ? "search " : "trees ") + std::to_string(number + 1));
    std::size_t sum = 0;
    for (std::size_t i = 0; i < round.items.size(); ++i) {
      const BatchItem& item = round.items[i];
      if (item.hasTree()) {
        sum += leavesOf(item);
      } else {  // it will not improve in the next round
        source_[i].status = item.status;
        source_[i].error = item.error;
      }
    }
    for (std::size_t k = 0; k < waiting_.size(); ++k) {
      const BatchItem& item = round.items[waiting_[k]];
      if (!item.hasTree()) continue;
      if (item.status == ItemStatus::Built) built_.insert(item.key);
      round.errors.push_back(item.result.figures.ratio->ratio);
      const auto n = static_cast<double>(leavesOf(item));
      const double error = isForLeaves(aim, k) ? errorOf(item) : std::max(errorOf(item), scale_);
      // The known errors are of quick trees, or for tolerances with another scale.
      if (number == 0 || item.result.figures.isGraded())
        curves_[k].moveTo(n, error);
      else
        curves_[k].add(n, error);
    }
    leaveOutFailed();
    std::sort(round.errors.begin(), round.errors.end(), std::greater<>());
    round.spent = budget_.is_time ? stepTime(round.items) : static_cast<double>(sum);
    round.fits = round.spent <= budget_.amount;
    aimAgain(static_cast<double>(sum), round.spent);
    rounds_.push_back({.is_final = !search,
                       .leaves = sum,
                       .worst_ratio = round.errors.empty() ? std::nullopt : std::optional(round.errors.front()),
                       .model_us = budget_.is_time ? std::optional(round.spent) : std::nullopt});
    return round;
  }

  void leaveOutFailed() {
    for (std::size_t k = waiting_.size(); k-- > 0;) {
      if (source_[waiting_[k]].status == ItemStatus::Waiting) continue;
      const auto at = static_cast<std::ptrdiff_t>(k);
      waiting_.erase(waiting_.begin() + at);
      max_.erase(max_.begin() + at);
      curves_.erase(curves_.begin() + at);
      shares_.leaves.erase(shares_.leaves.begin() + at);
    }
  }

  /// For a budget of time: sets the number of leaves to request, if `leaves` spent `spent`. The time of a step is
  /// approximately a power of the leaves, which two rounds determine.
  void aimAgain(double leaves, double spent) {
    if (!budget_.is_time || !(spent > 0)) return;
    double power = 0.5;
    if (last_spent_ > 0 && std::abs(std::log(leaves / last_leaves_)) > kSameLeaves)
      power = std::clamp(std::log(spent / last_spent_) / std::log(leaves / last_leaves_), 0.25, 1.5);
    last_spent_ = spent, last_leaves_ = leaves;
    const double factor = std::clamp(std::pow(kAim * budget_.amount / spent, 1 / power), 1.0 / 16, 16.0);
    aim_ = std::max(static_cast<std::size_t>(factor * leaves), fixed_ + waiting_.size());
  }

  double stepTime(const std::vector<BatchItem>& items) {
    const std::optional<runtime::Scene> scene = runtimeScene(context_.scene, items);
    if (!scene) return 0;
    if (paths_.empty()) paths_ = randomContacts(*scene, kSceneContacts);
    const std::optional<StepCost> cost = measureSteps(*scene, paths_, false);
    return cost ? cost->model_us_p99 : 0;
  }

  Budget budget_;
  ToolPaths paths_;
  bool random_;  // random contacts instead of recorded paths
  const BatchContext& context_;
  std::vector<BatchItem> source_;     // as read
  std::vector<std::size_t> waiting_;  // indices of those to build
  std::vector<std::size_t> max_;      // largest numbers of leaves of these
  std::vector<ErrorCurve> curves_;    // of these
  std::size_t fixed_ = 0;             // leaves of the items that came as trees
  std::size_t aim_ = 0;               // number of leaves to request
  LeafShares shares_;                 // expected of the trees of the present round
  double scale_ = 1;                  // factor on the tolerances at which all can be met
  double last_leaves_ = 0, last_spent_ = 0;
  std::set<std::string> built_;  // keys
  Round best_;
  std::vector<BudgetRound> rounds_;
};

}  // namespace

BudgetResult buildWithin(const Budget& budget, std::vector<BatchItem>& items, ToolPaths paths, const BatchContext& context) {
  BudgetSearch search(budget, items, std::move(paths), context);
  // The report compares with the scene's own tolerances, if there are any.
  std::vector<bool> has_tolerance;
  for (const BatchItem& item : items) has_tolerance.push_back(item.job.settings.tolerance_mm > 0);
  items = search.run();
  for (std::size_t i = 0; i < items.size(); ++i)
    if (!has_tolerance[i] && items[i].hasTree()) {
      items[i].result.figures.tolerance_mm.reset();
      items[i].result.figures.tolerance_met.reset();
    }
  return search.result();
}

}  // namespace spheretree::pipeline
