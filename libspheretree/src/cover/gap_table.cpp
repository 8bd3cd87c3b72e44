// SPDX-License-Identifier: GPL-3.0-or-later
#include "cover/gap_table.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <functional>
#include <queue>

namespace spheretree::builder {

namespace {

constexpr std::size_t kMaxEntries = 25'000'000, kEntriesASample = 400;

}  // namespace

GapTable::GapTable(const SampleIndex& samples, std::span<const Ball> candidates, double limit) {
  const std::size_t n = candidates.size();
  constexpr std::size_t kChunk = 64;
  const std::size_t chunks = (n + kChunk - 1) / kChunk;
  std::vector<std::vector<Entry>> found(chunks);
  std::vector<std::uint32_t> count(n, 0);
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    for (std::size_t c = chunk * kChunk; c < std::min(n, (chunk + 1) * kChunk); ++c) {
      const std::size_t before = found[chunk].size();
      samples.within(candidates[c].centre, candidates[c].radius + limit, [&](std::uint32_t i, double distance) {
        found[chunk].push_back({static_cast<std::uint32_t>(i), static_cast<float>(distance - candidates[c].radius)});
      });
      count[c] = static_cast<std::uint32_t>(found[chunk].size() - before);
    }
  });
  candidate_begin_.assign(n + 1, 0);
  for (std::size_t c = 0; c < n; ++c) candidate_begin_[c + 1] = candidate_begin_[c] + count[c];
  by_candidate_.resize(candidate_begin_[n]);
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    std::copy(found[chunk].begin(), found[chunk].end(),
              by_candidate_.begin() + static_cast<std::ptrdiff_t>(candidate_begin_[chunk * kChunk]));
    found[chunk] = {};
  });
  transpose(samples.size());
}

void GapTable::transpose(std::size_t samples) {
  sample_begin_.assign(samples + 1, 0);
  for (const Entry& e : by_candidate_) ++sample_begin_[e.id + 1];
  for (std::size_t s = 0; s < samples; ++s) sample_begin_[s + 1] += sample_begin_[s];
  by_sample_.resize(by_candidate_.size());
  std::vector<std::size_t> at(sample_begin_.begin(), sample_begin_.end() - 1);
  for (std::size_t c = 0; c + 1 < candidate_begin_.size(); ++c)
    for (std::size_t k = candidate_begin_[c]; k < candidate_begin_[c + 1]; ++k)
      by_sample_[at[by_candidate_[k].id]++] = {static_cast<std::uint32_t>(c), by_candidate_[k].gap};
}

void thinToFit(const SampleIndex& samples, double limit, std::vector<Ball>& candidates) {
  constexpr std::size_t kStride = 64;
  std::size_t entries = 0;
  for (std::size_t c = 0; c < candidates.size(); c += kStride)
    samples.within(candidates[c].centre, candidates[c].radius + limit, [&](std::uint32_t, double) { ++entries; });
  const std::size_t every = 1 + kStride * entries / std::min(kMaxEntries, kEntriesASample * samples.size());
  if (every == 1) return;
  std::size_t kept = 0;
  for (std::size_t c = 0; c < candidates.size(); c += every) candidates[kept++] = candidates[c];
  candidates.resize(kept);
}

std::vector<std::uint32_t> greedyCover(const GapTable& table, float h, std::size_t max_count) {
  struct Gain {
    std::uint32_t gain, candidate;
    bool operator<(const Gain& o) const { return gain != o.gain ? gain < o.gain : candidate > o.candidate; }
  };
  std::vector<Gain> heap(table.candidates());
  for (std::size_t c = 0; c < heap.size(); ++c) {
    std::uint32_t gain = 0;
    for (const GapTable::Entry& e : table.ofCandidate(c)) gain += e.gap <= h;
    heap[c] = {gain, static_cast<std::uint32_t>(c)};
  }
  std::priority_queue<Gain> queue(std::less<Gain>(), std::move(heap));
  std::vector<char> covered(table.samples(), 0);
  std::size_t open = table.samples();
  std::vector<std::uint32_t> chosen;
  while (open > 0) {
    if (queue.empty() || chosen.size() == max_count) return {};
    Gain top = queue.top();
    queue.pop();
    if (top.gain == 0) return {};
    std::uint32_t gain = 0;
    for (const GapTable::Entry& e : table.ofCandidate(top.candidate)) gain += e.gap <= h && !covered[e.id];
    if (gain < top.gain) {
      if (gain > 0) queue.push({gain, top.candidate});
      continue;
    }
    for (const GapTable::Entry& e : table.ofCandidate(top.candidate))
      if (e.gap <= h && !covered[e.id]) covered[e.id] = 1, --open;
    chosen.push_back(top.candidate);
  }
  return chosen;
}

}  // namespace spheretree::builder
