// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/hull_complex.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <utility>

#include "hulls/hull_cover.h"
#include "hulls/inscribed_ball.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kMaxBalls = 1000;  // that are joined
constexpr double kFirstGap = 8;          // of the first balls, as a multiple of the tolerance
constexpr double kGap = 0.8;             // largest gap between a ball and the sample it is for, as a share of the tolerance
constexpr double kBetween = 0.04;        // share of the tolerance for what lies between samples
constexpr int kRounds = 8;               // of more balls

}  // namespace

HullComplex::HullComplex(const FitTask& task)
    : task_(&task),
      all_(task.settings.tolerance - 2 * task.settings.margin()),
      most_((1 - kBetween) * task.settings.tolerance - 2 * task.settings.margin()),
      samples_(task.samples()) {}

std::vector<std::uint32_t> HullComplex::around(std::uint32_t v) const {
  std::vector<std::uint32_t> out;
  if (v < of_.size())
    for (const std::uint32_t i : of_[v])
      if (simplices_[i].is_alive) out.push_back(i);
  return out;
}

std::vector<std::uint32_t> HullComplex::neighbours(std::uint32_t v) const {
  std::vector<std::uint32_t> out;
  for (const std::uint32_t i : around(v))
    for (const std::uint32_t w : simplices_[i].corners())
      if (w != v) out.push_back(w);
  std::ranges::sort(out);
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

bool HullComplex::addFirstBalls() {
  addBalls(kFirstGap * task_->settings.tolerance, kMaxBalls / 4);
  if (balls_.empty()) addBalls(most_, 1);
  return !balls_.empty();
}

// Adds balls, each below the sample that needs the most, until none needs more than `enough`.
void HullComplex::addBalls(double enough, std::size_t count) {
  while (balls_.size() < std::min(count, kMaxBalls)) {
    const auto next = std::ranges::max_element(samples_, {}, &FitSample::cost);
    if (!(next->cost > enough)) break;
    next->cost = -kInfinity;
    const double gap = kGap * task_->settings.tolerance;
    Ball ball = ballBelow(task_->field, next->point, next->normal, gap);
    if (!(ball.radius > 0)) continue;
    ball = centred(task_->field, ball, next->point, gap);
    balls_.push_back(ball);
    for (FitSample& s : samples_) s.cost = std::min(s.cost, (s.point - ball.centre).norm() - ball.radius);
  }
}

void HullComplex::join(std::vector<Ball> balls) {
  balls_ = std::move(balls);
  for (int round = 0;; ++round) {
    simplices_ = triangulated(task_->field, balls_, most_);
    holdSamples();
    const std::size_t before = balls_.size();
    if (round < kRounds) addBalls(most_, before + before / 2);
    if (balls_.size() == before) break;
  }
  std::erase_if(simplices_, [](const Simplex& s) { return s.samples.empty(); });
  compact();
}

// Each by the hull of least cost among those near it, or among all if none is near.
void HullComplex::holdSamples() {
  std::vector<Eigen::AlignedBox3d> box;
  for (const Simplex& s : simplices_) box.push_back(boxOf(grownBy(s.hull, task_->settings.tolerance)));
  std::vector<std::uint32_t> best(samples_.size(), 0);
  tbb::parallel_for(std::size_t{0}, best.size(), [&](std::size_t i) {
    FitSample& sample = samples_[i];
    sample.cost = kInfinity;
    for (const bool is_near : {true, false}) {
      for (std::uint32_t s = 0; s < box.size(); ++s) {
        if (!simplices_[s].is_alive || (is_near && !box[s].contains(sample.point))) continue;
        if (const double cost = simplices_[s].costOf(sample.point); cost < sample.cost) sample.cost = cost, best[i] = s;
      }
      if (sample.cost < kInfinity) break;
    }
  });
  for (Simplex& s : simplices_) s.samples.clear();
  for (std::uint32_t i = 0; i < best.size(); ++i) simplices_[best[i]].samples.push_back(i);
}

bool HullComplex::addBare() {
  std::vector<Hull> hulls;
  for (const Simplex& s : simplices_)
    if (s.is_alive && s.overhang < most_) hulls.push_back(grownBy(s.hull, all_ - s.overhang));
  const std::vector<FitSample> bare = task_->bareOf(HullCover(hulls, task_->settings.margin())).samples;
  samples_.insert(samples_.end(), bare.begin(), bare.end());
  if (!bare.empty()) holdSamples();
  return !bare.empty();
}

void HullComplex::apply(const HullChange& change) {
  for (const std::uint32_t i : around(change.from)) simplices_[i].is_alive = false, simplices_[i].samples.clear();
  if (change.to == balls_.size()) balls_.push_back(change.ball), of_.emplace_back();
  for (const auto& [p, cost] : change.costs) samples_[p].cost = cost;
  for (const auto& [s, p] : change.kept) simplices_[s].samples.push_back(p);
  for (const Simplex& s : change.made) {
    for (const std::uint32_t v : s.corners()) of_[v].push_back(static_cast<std::uint32_t>(simplices_.size()));
    simplices_.push_back(s);
  }
}

void HullComplex::prune() {
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < simplices_.size(); ++i)
    if (simplices_[i].is_alive) order.push_back(i);
  std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return simplices_[i].samples.size(); });
  for (const std::uint32_t i : order) {
    Simplex& gone = simplices_[i];
    std::vector<std::pair<std::uint32_t, double>> best(gone.samples.size(), {0, kInfinity});
    tbb::parallel_for(std::size_t{0}, best.size(), [&](std::size_t k) {
      for (const std::uint32_t j : order)
        if (j != i && simplices_[j].is_alive)
          if (const double cost = simplices_[j].costOf(samples_[gone.samples[k]].point); cost < best[k].second) best[k] = {j, cost};
    });
    if (std::ranges::any_of(best, [&](const auto& b) { return b.second > most_; })) continue;
    gone.is_alive = false;
    for (std::size_t k = 0; k < best.size(); ++k) {
      samples_[gone.samples[k]].cost = best[k].second;
      simplices_[best[k].first].samples.push_back(gone.samples[k]);
    }
    gone.samples.clear();
  }
  compact();
}

void HullComplex::compact() {
  std::erase_if(simplices_, [](const Simplex& s) { return !s.is_alive; });
  of_.assign(balls_.size(), {});
  for (std::uint32_t i = 0; i < simplices_.size(); ++i)
    for (const std::uint32_t v : simplices_[i].corners()) of_[v].push_back(i);
}

void HullComplex::restore(HullComplex before) {
  before.samples_.insert(before.samples_.end(), samples_.begin() + static_cast<std::ptrdiff_t>(before.samples_.size()), samples_.end());
  *this = std::move(before);
  holdSamples();
}

}  // namespace spheretree::builder
