// SPDX-License-Identifier: GPL-3.0-or-later
// The discrete form of a cover: which candidate covers which sample at which stand-off, and a first greedy choice of
// candidates.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/ball.h"
#include "geometry/sample_index.h"

namespace spheretree::builder {

/// The entries with gap = |p - c| - d(c) <= limit, by candidate and by sample. Gaps in float only guide the search;
/// results are computed in double.
class GapTable {
 public:
  struct Entry {
    std::uint32_t id;
    float gap;
  };

  GapTable(const SampleIndex& samples, std::span<const Ball> candidates, double limit);

  std::size_t candidates() const { return candidate_begin_.size() - 1; }
  std::size_t samples() const { return sample_begin_.size() - 1; }
  std::span<const Entry> ofCandidate(std::size_t c) const { return span(by_candidate_, candidate_begin_, c); }
  std::span<const Entry> ofSample(std::size_t s) const { return span(by_sample_, sample_begin_, s); }

 private:
  static std::span<const Entry> span(const std::vector<Entry>& entries, const std::vector<std::size_t>& begin, std::size_t i) {
    return {entries.data() + begin[i], begin[i + 1] - begin[i]};
  }
  void transpose(std::size_t samples);

  std::vector<std::size_t> candidate_begin_, sample_begin_;
  std::vector<Entry> by_candidate_, by_sample_;
};

/// Removes candidates evenly until a gap table up to `limit` has at most about 400 entries a sample and 25 million
/// entries (of 16 bytes) in total. Otherwise very slender, very round or very deep trees would exhaust the memory.
void thinToFit(const SampleIndex& samples, double limit, std::vector<Ball>& candidates);

/// Lazy greedy set cover at stand-off `h`. Empty if it would need more than `max_count` sets. Ties go to the lower
/// candidate.
std::vector<std::uint32_t> greedyCover(const GapTable& table, float h, std::size_t max_count);

}  // namespace spheretree::builder
