// SPDX-License-Identifier: GPL-3.0-or-later
// Weighting local search for set covering. Paper: C. Gao, X. Yao, T. Weise, J. Li. An efficient local search heuristic
// with row weighting for the unicost set covering problem. EJOR 246(3), 2015. Here the number of sets is fixed and the
// stand-off decreases: whenever every sample is covered, the sets shrink until one sample is not.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <span>
#include <vector>

#include "cover/gap_table.h"
#include "cover/uncovered_set.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

class SwapSearch {
 public:
  SwapSearch(GapTable& table, std::vector<std::uint32_t> chosen, std::uint64_t seed)
      : table_(table),
        chosen_(std::move(chosen)),
        selected_(table.candidates(), 0),
        weight_(table.samples(), 1),
        stamp_(table.candidates(), 0),
        random_(seed) {
    for (const std::uint32_t c : chosen_) selected_[c] = 1;
  }

  // The best cover found before `work` entries of the table were touched, starting at stand-off `h`, with at most
  // `spheres` sets.
  std::vector<std::uint32_t> run(float h, std::size_t spheres, std::uint64_t work, const Progress& progress) {
    std::vector<std::uint32_t> best = chosen_;
    restart(h);
    std::int64_t clock = 0;
    for (std::uint64_t step = 0; touched_ < work; ++step) {
      if (step % 256 == 0) progress.check();
      while (open_.empty()) {
        best = chosen_;
        restart(nextStandOff());
      }
      if (chosen_.size() >= spheres) remove(smallestUsefulness(), ++clock);
      const std::uint32_t sample = open_.anyOf(random_());
      const std::uint32_t candidate = largestUsefulness(sample);
      if (candidate == kNone) return best;  // no candidate covers this sample at this stand-off
      add(candidate, ++clock);
      last_added_ = candidate;
      for (const std::uint32_t s : open_) {
        ++weight_[s];
        touched_ += table_.ofSample(s).size();
        for (const GapTable::Entry& e : table_.ofSample(s)) score_[e.id] += e.gap <= h_;
      }
    }
    if (open_.empty()) best = chosen_;
    return best;
  }

 private:
  static constexpr float kSwapStep = 0.004f;   // share by which the next stand-off is below that of the present cover
  static constexpr float kRestrictAt = 0.97f;  // the table is restricted when the stand-off is below this share of its limit
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  // Slightly below the largest gap of the current cover.
  float nextStandOff() {
    min_.assign(table_.samples(), std::numeric_limits<float>::infinity());
    for (const std::uint32_t c : chosen_)
      for (const GapTable::Entry& e : table_.ofCandidate(c)) min_[e.id] = std::min(min_[e.id], e.gap);
    const float largest = *std::max_element(min_.begin(), min_.end());
    return largest - kSwapStep * std::abs(largest);
  }

  // Recomputes the counts at stand-off `h`. Only samples that no set or one set covers contribute to a score, so that
  // the cost is that of the entries of the chosen sets, not of the table. Entries above the limit stay in the table
  // until there are enough of them to justify a pass over it.
  void restart(float h) {
    touched_ += table_.samples() + table_.candidates();
    if (h < kRestrictAt * restricted_) {
      table_.restrict(h);
      restricted_ = h;
    }
    h_ = h;
    cover_.assign(table_.samples(), 0);
    open_.reset(table_.samples());
    for (const std::uint32_t c : chosen_)
      for (const GapTable::Entry& e : table_.ofCandidate(c)) cover_[e.id] += e.gap <= h_;
    score_.assign(table_.candidates(), 0);
    for (std::uint32_t s = 0; s < cover_.size(); ++s) {
      if (cover_[s] > 0) continue;
      open_.insert(s);
      for (const GapTable::Entry& e : table_.ofSample(s))
        if (e.gap <= h_) score_[e.id] += weight_[s];
    }
    for (const std::uint32_t c : chosen_)
      for (const GapTable::Entry& e : table_.ofCandidate(c))
        if (e.gap <= h_ && cover_[e.id] == 1) score_[c] += weight_[e.id];
  }
  // score: weight of the samples that an unselected set would newly cover, or that a selected set alone covers.
  std::size_t smallestUsefulness() const {
    std::size_t best = kNone;
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      const std::uint32_t c = chosen_[i];
      if (c == last_added_) continue;
      if (best == kNone || score_[c] < score_[chosen_[best]] || (score_[c] == score_[chosen_[best]] && stamp_[c] < stamp_[chosen_[best]]))
        best = i;
    }
    return best == kNone ? 0 : best;
  }
  std::uint32_t largestUsefulness(std::uint32_t sample) const {
    std::uint32_t best = kNone;
    for (const GapTable::Entry& e : table_.ofSample(sample)) {
      if (e.gap > h_ || selected_[e.id] || e.id == last_removed_) continue;
      if (best == kNone || score_[e.id] > score_[best] || (score_[e.id] == score_[best] && stamp_[e.id] < stamp_[best])) best = e.id;
    }
    if (best == kNone)
      for (const GapTable::Entry& e : table_.ofSample(sample))
        if (e.gap <= h_ && !selected_[e.id]) best = e.id;
    return best;
  }

  void remove(std::size_t index, std::int64_t clock) {
    const std::uint32_t c = chosen_[index];
    chosen_[index] = chosen_.back();
    chosen_.pop_back();
    selected_[c] = 0;
    stamp_[c] = clock;
    last_removed_ = c;
    touched_ += table_.ofCandidate(c).size();
    for (const GapTable::Entry& e : table_.ofCandidate(c)) {
      const std::uint32_t s = e.id;
      if (e.gap > h_) continue;
      if (--cover_[s] == 0) {
        touched_ += table_.ofSample(s).size();
        for (const GapTable::Entry& other : table_.ofSample(s))
          if (other.id != c && other.gap <= h_) score_[other.id] += weight_[s];
        open_.insert(s);
      } else if (cover_[s] == 1) {
        for (const GapTable::Entry& other : table_.ofSample(s))
          if (other.gap <= h_ && selected_[other.id]) {
            score_[other.id] += weight_[s];
            break;
          }
      }
    }
  }
  void add(std::uint32_t c, std::int64_t clock) {
    touched_ += table_.ofCandidate(c).size();
    for (const GapTable::Entry& e : table_.ofCandidate(c)) {
      const std::uint32_t s = e.id;
      if (e.gap > h_) continue;
      if (++cover_[s] == 1) {
        touched_ += table_.ofSample(s).size();
        for (const GapTable::Entry& other : table_.ofSample(s))
          if (other.id != c && other.gap <= h_) score_[other.id] -= weight_[s];
        open_.erase(s);
      } else if (cover_[s] == 2) {
        for (const GapTable::Entry& other : table_.ofSample(s))
          if (other.gap <= h_ && selected_[other.id]) {
            score_[other.id] -= weight_[s];
            break;
          }
      }
    }
    selected_[c] = 1;
    stamp_[c] = clock;
    chosen_.push_back(c);
  }

  GapTable& table_;
  std::vector<std::uint32_t> chosen_;
  std::vector<char> selected_;
  std::vector<std::int64_t> weight_, score_, stamp_;
  std::vector<float> min_;
  std::vector<std::uint32_t> cover_;
  UncoveredSet open_;  // samples in no chosen set
  std::uint64_t touched_ = 0;
  float h_ = 0, restricted_ = std::numeric_limits<float>::infinity();
  std::uint32_t last_added_ = kNone, last_removed_ = kNone;
  std::mt19937_64 random_;
};

}  // namespace spheretree::builder
