// SPDX-License-Identifier: GPL-3.0-or-later
// Sums with the same bits for any number of threads.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace spheretree::builder {

/// Calls one(i) for i < count on all threads.
template <class One>
void forEachIndex(std::size_t count, One&& one) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) one(i);
  });
}

/// Computes term(i) for i < count on all threads, and calls add(i, term) in the order of i. Terms are kept for a block
/// at a time.
template <class Term, class Compute, class Add>
void addInOrder(std::size_t count, Compute&& compute, Add&& add) {
  constexpr std::size_t kBlock = 0x4000;
  std::vector<Term> terms(std::min(count, kBlock));
  for (std::size_t first = 0; first < count; first += kBlock) {
    const std::size_t size = std::min(kBlock, count - first);
    forEachIndex(size, [&](std::size_t i) { terms[i] = compute(first + i); });
    for (std::size_t i = 0; i < size; ++i) add(first + i, terms[i]);
  }
}

}  // namespace spheretree::builder
