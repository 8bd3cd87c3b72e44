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

constexpr double kSameLeaves = 0.04;      // a smaller relative change does not justify another build
constexpr double kWellSpent = 0.9;        // share of the budget above which the number of leaves hardly changes any more
constexpr int kSearchRounds = 4;          // with quick trees
constexpr int kFinalRounds = 3;           // with the final trees
constexpr std::size_t kFirstLeaves = 64;  // for each object in the first round
constexpr double kAim = 0.98;             // share of the budget that is requested, so that the trees stay within it

std::size_t leavesOf(const BatchItem& item) { return item.result.figures.leaves; }

/// The error that more leaves reduce: the proven overhang as a multiple of its tolerance, or in mm if the scene has
/// none.
double errorOf(const BatchItem& item) {
  const TreeFigures& figures = item.result.figures;
  return figures.isGraded() ? item.job.scale * figures.ratio->least_met_mm.value() / *figures.least_tolerance_mm : figures.ratio->ratio;
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
      if (settings.builder != BuilderKind::Cover)
        throw tool::UsageError(items[i].source->name + ": a budget is for the builder cover, not " +
                               std::string(builder::name(settings.builder)) + ". Give it that builder, or build without a budget.");
      if (!(settings.tolerance_mm > 0)) settings.tolerance_mm = common;
      waiting_.push_back(i);
      most_.push_back(mostLeaves(context.scene, items[i]));
    }
    if (!budget.is_time && budget.amount < static_cast<double>(fixed_ + waiting_.size()))
      throw tool::UsageError("a budget of " + std::to_string(static_cast<std::size_t>(budget.amount)) +
                             " leaves is less than one for each of " + std::to_string(waiting_.size()) + " trees to build" +
                             (fixed_ > 0 ? " and " + std::to_string(fixed_) + " in trees given by the scene" : "") + ". Allow more.");
    curves_.resize(waiting_.size());
    aim_ = budget.is_time ? kFirstLeaves * waiting_.size() + fixed_ : static_cast<std::size_t>(budget.amount);
  }

  /// Returns the best round. The errors of quick trees determine the distribution of leaves, and those of the final
  /// trees correct it.
  std::vector<BatchItem> run() {
    if (waiting_.empty()) return source_;
    const std::size_t each = std::max<std::size_t>(1, (aim_ - fixed_) / waiting_.size());
    std::vector<std::size_t> leaves(waiting_.size(), std::min(kFirstLeaves, each));
    for (int round = 0; round < kSearchRounds; ++round)
      if (const Round built = build(leaves, true, round); redistribute(leaves, built) && round > 0) break;
    for (int round = 0; round < kFinalRounds; ++round) {
      Round built = build(leaves, false, round);
      const bool unchanged = redistribute(leaves, built) && built.fits;
      if (best_.items.empty() || isBetter(built, best_)) best_ = std::move(built);
      if (unchanged) break;
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
            .common_ratio = scale_,
            .has_recorded_paths = !random_,
            .rounds = rounds_};
  }

 private:
  struct Round {
    std::vector<BatchItem> items;
    std::vector<double> errors;  // in descending order
    double spent = 0;
    bool fits = false;
  };

  static bool isBetter(const Round& a, const Round& b) {
    return a.fits != b.fits ? a.fits : a.fits ? a.errors < b.errors : a.spent < b.spent;
  }

  Round build(const std::vector<std::size_t>& leaves, bool search, int number) {
    Round round;
    round.items = source_;
    for (std::size_t k = 0; k < waiting_.size(); ++k) {
      TreeJob& job = round.items[waiting_[k]].job;
      builder::BuildSettings& settings = job.settings;
      limitLeaves(settings, leaves[k]);
      if (search) {
        settings.quality = Quality::Quick;
        settings.skin = settings.skin && budget_.is_time;  // only the time of a step depends on it
      }
      if (job.work && settings.tolerance_mm > 0) job.scale = scale_;
    }
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
    auto asked = static_cast<double>(fixed_);
    for (std::size_t k = 0; k < waiting_.size(); ++k) {
      const BatchItem& item = round.items[waiting_[k]];
      if (!item.hasTree()) continue;
      if (item.status == ItemStatus::Built) built_.insert(item.key);
      round.errors.push_back(item.result.figures.ratio->ratio);
      const auto n = static_cast<double>(leaves[k]);
      asked += n;
      // The known errors are of quick trees, or for tolerances with another scale.
      if (number == 0 || item.result.figures.isGraded())
        curves_[k].moveTo(n, errorOf(item));
      else
        curves_[k].add(n, errorOf(item));
    }
    std::sort(round.errors.begin(), round.errors.end(), std::greater<>());
    round.spent = budget_.is_time ? stepTime(round.items) : static_cast<double>(sum);
    round.fits = round.spent <= budget_.amount;
    aimAgain(asked, round.spent);
    rounds_.push_back({.is_final = !search,
                       .leaves = sum,
                       .worst_ratio = round.errors.empty() ? std::nullopt : std::optional(round.errors.front()),
                       .model_us = budget_.is_time ? std::optional(round.spent) : std::nullopt});
    return round;
  }

  /// Sets the number of leaves to request, if `asked` of them spent `spent`: some become redundant, and the time of a
  /// step is approximately a power of the leaves, which two rounds determine. A well-spent number hardly changes, since
  /// the results fluctuate from number to number.
  void aimAgain(double asked, double spent) {
    if (!(spent > 0)) return;
    double power = 1;
    if (budget_.is_time) {
      power = 0.5;
      if (last_spent_ > 0 && std::abs(std::log(asked / last_asked_)) > kSameLeaves)
        power = std::clamp(std::log(spent / last_spent_) / std::log(asked / last_asked_), 0.25, 1.5);
      last_spent_ = spent, last_asked_ = asked;
    }
    const double share = spent / budget_.amount;
    double factor = std::clamp(std::pow(kAim / share, 1 / power), 1.0 / 16, 16.0);
    if (share <= 1 && share > kWellSpent) factor = budget_.is_time ? 1 : 1 + (1 - share) / 2;
    aim_ = std::max(static_cast<std::size_t>(factor * asked), fixed_ + waiting_.size());
  }

  /// Distributes the leaves again; true if the round already had this distribution. Small changes are not made.
  bool redistribute(std::vector<std::size_t>& leaves, const Round& built) {
    const LeafShares shares = shareLeaves(curves_, most_, aim_ - fixed_);
    scale_ = shares.error;
    bool unchanged = true;
    for (std::size_t k = 0; k < leaves.size(); ++k) {
      const double change = std::abs(static_cast<double>(shares.leaves[k]) - static_cast<double>(leaves[k]));
      if (built.fits && change <= std::max(1.0, kSameLeaves * static_cast<double>(leaves[k]))) continue;
      unchanged = unchanged && shares.leaves[k] == leaves[k];
      leaves[k] = shares.leaves[k];
    }
    return unchanged;
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
  std::vector<std::size_t> most_;     // largest numbers of leaves of these
  std::vector<ErrorCurve> curves_;    // of these
  std::size_t fixed_ = 0;             // leaves of the items that came as trees
  std::size_t aim_ = 0;               // number of leaves to request
  double scale_ = 1;                  // factor on the tolerances at which all can be met
  double last_asked_ = 0, last_spent_ = 0;
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
