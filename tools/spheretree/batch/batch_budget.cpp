// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/batch_budget.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "commands/command.h"

namespace spheretree::tool {
namespace {

using builder::BuilderKind;
using builder::Quality;

constexpr double kSameLeaves = 0.04;      // relative: not worth another build
constexpr double kWellSpent = 0.9;        // of the budget
constexpr int kSearchRounds = 4;          // with quick trees
constexpr int kFinalRounds = 3;           // with those that are kept
constexpr std::size_t kFirstLeaves = 64;  // of each object, to begin with
constexpr double kAim = 0.98;             // of the budget, to end up within

std::size_t leavesOf(const Item& item) { return item.result.record.at("leaves").get<std::size_t>(); }

/// What more leaves make smaller: the proven error as a multiple of its tolerance, or in mm where the scene gives none.
double errorOf(const Item& item) {
  const Json& record = item.result.record;
  const bool graded = record.contains("least_tolerance_mm");
  return graded ? item.job.scale * record.at("least_met_mm").get<double>() / record.at("least_tolerance_mm").get<double>()
                : record.at("tolerance_ratio").get<double>();
}

class BudgetSearch {
 public:
  BudgetSearch(const Budget& budget, const formats::SceneFile& scene, const std::vector<Item>& items, WorkSite* site, Hands hands,
               const Workshop& workshop)
      : budget_(budget),
        scene_(scene),
        site_(site),
        hands_(std::move(hands)),
        random_(hands_.empty()),
        workshop_(workshop),
        source_(items) {
    double common = 0;  // without a tolerance of its own, an object has the largest that the scene gives
    for (const Item& item : items) common = std::max(common, item.job.settings.tolerance_mm);
    for (std::size_t i = 0; i < items.size(); ++i) {
      if (items[i].hasTree()) fixed_ += leavesOf(items[i]);
      if (items[i].status != ItemStatus::Waiting) continue;
      builder::BuildSettings& settings = source_[i].job.settings;
      if (settings.builder != BuilderKind::Cover)
        throw UsageError(items[i].source->name + ": --budget is for the builder cover, not " + std::string(name(settings.builder)) +
                         ". Give it that builder, or build without --budget.");
      if (!(settings.tolerance_mm > 0)) settings.tolerance_mm = common;
      waiting_.push_back(i);
      most_.push_back(mostLeaves(scene, items[i]));
    }
    if (!budget.is_time && budget.amount < static_cast<double>(fixed_ + waiting_.size()))
      throw UsageError("--budget " + std::to_string(static_cast<std::size_t>(budget.amount)) + " is less than a leaf for each of " +
                       std::to_string(waiting_.size()) + " trees to build" +
                       (fixed_ > 0 ? " and " + std::to_string(fixed_) + " in trees that the scene names" : "") + ". Allow more.");
    curves_.resize(waiting_.size());
    aim_ = budget.is_time ? kFirstLeaves * waiting_.size() + fixed_ : static_cast<std::size_t>(budget.amount);
  }

  /// The best round. The errors of quick trees say how to share the leaves, those of the final ones put it right.
  std::vector<Item> run() {
    if (waiting_.empty()) return source_;
    const std::size_t each = std::max<std::size_t>(1, (aim_ - fixed_) / waiting_.size());
    std::vector<std::size_t> leaves(waiting_.size(), std::min(kFirstLeaves, each));
    for (int round = 0; round < kSearchRounds; ++round)
      if (const Round built = build(leaves, true, round); isSettled(leaves, built) && round > 0) break;
    for (int round = 0; round < kFinalRounds; ++round) {
      Round built = build(leaves, false, round);
      const bool settled = isSettled(leaves, built) && built.fits;
      if (best_.items.empty() || isBetter(built, best_)) best_ = std::move(built);
      if (settled) break;
    }
    for (Item& item : best_.items)
      if (built_.count(item.key) > 0) item.status = ItemStatus::Built;
    return std::move(best_.items);
  }

  Json report() const {
    Json out{{"of", budget_.is_time ? "us" : "leaves"}, {"amount", budget_.amount}, {"spent", best_.spent}, {"met", best_.fits}};
    if (!best_.errors.empty()) out["worst_ratio"] = best_.errors.front();
    out["common_ratio"] = scale_;
    if (budget_.is_time) out["hands"] = random_ ? "random touches" : "recorded";
    out["rounds"] = rounds_;
    return out;
  }

 private:
  struct Round {
    std::vector<Item> items;
    std::vector<double> errors;  // the largest first
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
      if (search) settings.quality = Quality::Quick;
      if (job.site && settings.tolerance_mm > 0) job.scale = scale_;
    }
    buildItems(round.items, site_, workshop_, "budget, " + std::string(search ? "search " : "trees ") + std::to_string(number + 1));
    std::size_t sum = 0;
    for (std::size_t i = 0; i < round.items.size(); ++i) {
      const Item& item = round.items[i];
      if (item.hasTree()) {
        sum += leavesOf(item);
      } else {  // it will not do better the next time
        source_[i].status = item.status;
        source_[i].error = item.error;
      }
    }
    auto asked = static_cast<double>(fixed_);
    for (std::size_t k = 0; k < waiting_.size(); ++k) {
      const Item& item = round.items[waiting_[k]];
      if (!item.hasTree()) continue;
      if (item.status == ItemStatus::Built) built_.insert(item.key);
      round.errors.push_back(item.result.record.at("tolerance_ratio").get<double>());
      const auto n = static_cast<double>(leaves[k]);
      asked += n;
      // What was known was of quick trees, or for tolerances of another scale.
      if (number == 0 || item.result.record.contains("least_tolerance_mm"))
        curves_[k].moveTo(n, errorOf(item));
      else
        curves_[k].add(n, errorOf(item));
    }
    std::sort(round.errors.begin(), round.errors.end(), std::greater<>());
    round.spent = budget_.is_time ? stepTime(round.items) : static_cast<double>(sum);
    round.fits = round.spent <= budget_.amount;
    aimAgain(asked, round.spent);
    Json line{{"trees", search ? "quick" : "final"}, {"leaves", sum}};
    if (!round.errors.empty()) line["worst_ratio"] = round.errors.front();
    if (budget_.is_time) line["model_us"] = round.spent;
    rounds_.push_back(std::move(line));
    return round;
  }

  /// How many leaves to ask for, if `asked` of them spent so much of the budget: some turn out needless; and the time of a step is about a
  /// power of the leaves, which two rounds tell. What is well spent stays nearly as it is: every number of leaves has luck of its own.
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

  /// Shares the leaves anew; true if that is what the round had. Small changes are not made.
  bool isSettled(std::vector<std::size_t>& leaves, const Round& built) {
    const LeafShares shares = shareLeaves(curves_, most_, aim_ - fixed_);
    scale_ = shares.error;
    bool settled = true;
    for (std::size_t k = 0; k < leaves.size(); ++k) {
      const double change = std::abs(static_cast<double>(shares.leaves[k]) - static_cast<double>(leaves[k]));
      if (built.fits && change <= std::max(1.0, kSameLeaves * static_cast<double>(leaves[k]))) continue;
      settled = settled && shares.leaves[k] == leaves[k];
      leaves[k] = shares.leaves[k];
    }
    return settled;
  }

  double stepTime(const std::vector<Item>& items) {
    const std::optional<runtime::Scene> scene = runtimeScene(scene_, items);
    if (!scene) return 0;
    if (hands_.empty()) hands_ = randomTouches(*scene, kTouches);
    const std::optional<StepCost> cost = measureSteps(*scene, hands_, false);
    return cost ? cost->model_us_p99 : 0;
  }

  Budget budget_;
  const formats::SceneFile& scene_;
  WorkSite* site_;
  Hands hands_;
  bool random_;
  Workshop workshop_;
  std::vector<Item> source_;          // as they were read
  std::vector<std::size_t> waiting_;  // those to build
  std::vector<std::size_t> most_;     // leaves, of these
  std::vector<ErrorCurve> curves_;    // of these
  std::size_t fixed_ = 0;             // leaves of those that came as trees
  std::size_t aim_ = 0;               // leaves to ask for
  double scale_ = 1;                  // of the tolerances, for which all could be met
  double last_asked_ = 0, last_spent_ = 0;
  std::set<std::string> built_;  // keys
  Round best_;
  Json rounds_ = Json::array();
};

}  // namespace

Json buildWithin(const Budget& budget, const formats::SceneFile& scene, std::vector<Item>& items, WorkSite* site, Hands hands,
                 const Workshop& workshop) {
  BudgetSearch search(budget, scene, items, site, std::move(hands), workshop);
  // The scene's own tolerance, if any, is what the report compares with.
  std::vector<bool> has_tolerance;
  for (const Item& item : items) has_tolerance.push_back(item.job.settings.tolerance_mm > 0);
  items = search.run();
  for (std::size_t i = 0; i < items.size(); ++i)
    if (!has_tolerance[i] && items[i].hasTree()) items[i].result.record["tolerance_mm"] = items[i].result.record["tolerance_met"] = nullptr;
  return search.report();
}

}  // namespace spheretree::tool
