// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/reduce_expand.h"

#include <algorithm>
#include <bit>
#include <cstdint>

#include "spheretree/core/rounding.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr int kExpandBisections = 10;

// Which points each ball contains at one stand-off.
class Held {
 public:
  Held(const Region& region, double stand_off) : words_((region.points.size() + 63) / 64), bits_(region.pool.size() * words_, 0) {
    for (std::size_t b = 0; b < region.pool.size(); ++b) {
      const FittedBall& ball = region.pool[b];
      const double reach = ball.clearance + stand_off;
      if (!(reach > 0)) continue;
      for (std::size_t i = 0; i < region.points.size(); ++i)
        if ((region.points[i] - ball.centre).squaredNorm() <= reach * reach) bits_[b * words_ + i / 64] |= std::uint64_t{1} << i % 64;
    }
  }
  std::span<std::uint64_t> of(std::size_t ball) { return {bits_.data() + ball * words_, words_}; }

 private:
  std::size_t words_;
  std::vector<std::uint64_t> bits_;
};

// Selects balls, each the one that makes most of the others redundant: they contain no point that is not in it. Returns
// nothing if more than `max_count` would be selected.
std::vector<std::size_t> select(const Region& region, double stand_off, std::size_t max_count) {
  Held held(region, stand_off);
  std::vector<std::size_t> left, chosen;
  std::size_t covered = 0;
  for (std::size_t b = 0; b < region.pool.size(); ++b)
    if (std::ranges::any_of(held.of(b), [](std::uint64_t word) { return word != 0; })) left.push_back(b);
  while (!left.empty()) {
    if (chosen.size() == max_count) return {};
    // The first word with a point decides nearly always that a ball is not within another one.
    std::vector<std::size_t> first(region.pool.size(), 0);
    for (const std::size_t b : left)
      first[b] = static_cast<std::size_t>(std::ranges::find_if(held.of(b), [](auto w) { return w != 0; }) - held.of(b).begin());
    std::size_t best = left[0], most = 0;
    for (const std::size_t b : left) {
      const std::span<const std::uint64_t> own = held.of(b);
      std::size_t redundant = 0;
      for (const std::size_t other : left) {
        const std::span<const std::uint64_t> theirs = held.of(other);
        std::size_t word = first[other];
        while (word < own.size() && (theirs[word] & ~own[word]) == 0) ++word;
        redundant += word == own.size();
      }
      if (redundant > most) most = redundant, best = b;
    }
    chosen.push_back(best);
    const std::span<std::uint64_t> own = held.of(best);
    for (const std::uint64_t word : own) covered += static_cast<std::size_t>(std::popcount(word));
    std::vector<std::uint64_t> taken(own.begin(), own.end());
    std::erase_if(left, [&](std::size_t b) {
      bool is_empty = true;
      const std::span<std::uint64_t> bits = held.of(b);
      for (std::size_t word = 0; word < bits.size(); ++word) is_empty = (bits[word] &= ~taken[word]) == 0 && is_empty;
      return is_empty;
    });
  }
  return covered == region.points.size() ? chosen : std::vector<std::size_t>();
}

}  // namespace

std::vector<FittedBall> reduceExpand(const Region& region) {
  if (region.pool.empty() || region.points.empty()) return {};
  // Below `low` some point is in no ball; at `high` one ball contains all points.
  std::vector<double> nearest(region.points.size(), kInfinity);
  double low = 0, high = kInfinity;
  std::size_t widest = 0;
  for (std::size_t b = 0; b < region.pool.size(); ++b) {
    double largest = 0;
    for (std::size_t i = 0; i < region.points.size(); ++i) {
      const double gap = (region.points[i] - region.pool[b].centre).norm() - region.pool[b].clearance;
      largest = std::max(largest, gap);
      nearest[i] = std::min(nearest[i], gap);
    }
    if (largest < high) high = largest, widest = b;
  }
  for (const double gap : nearest) low = std::max(low, gap);

  std::vector<std::size_t> cover{widest};
  double stand_off = high;
  const auto attempt = [&](double trial) {
    std::vector<std::size_t> found = select(region, trial, region.max_balls);
    if (found.empty()) return false;
    cover = std::move(found);
    stand_off = high = trial;
    return true;
  };
  bool done = region.target_overhang >= high;
  if (!done && region.target_overhang > low) {
    done = attempt(region.target_overhang);
    if (!done) low = region.target_overhang;
  }
  for (int i = 0; i < kExpandBisections && !done && low < high; ++i) {
    const double middle = 0.5 * (low + high);
    if (!attempt(middle)) low = middle;
  }
  std::vector<FittedBall> balls;
  for (const std::size_t b : cover) {
    const FittedBall& medial = region.pool[b];
    balls.push_back({medial.centre, (medial.clearance + stand_off) * (1 + kRounding), medial.clearance});
  }
  return balls;
}

}  // namespace spheretree::builder
