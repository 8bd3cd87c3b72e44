// SPDX-License-Identifier: GPL-3.0-or-later
// Transfers every value from one thread to another, in order: a lock-free ring buffer for one writer and one reader. If
// it is full, a value is dropped and counted; the writer never waits.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace spheretree::view {

template <class Value>
class StepRing {
 public:
  /// `capacity`: number of values, a power of two. Allocates and touches all memory here.
  explicit StepRing(std::size_t capacity) : slots_(capacity) {}

  /// Writer: returns false, and counts the value as dropped, if the ring buffer is full.
  bool push(const Value& value) noexcept {
    const std::uint64_t at = written_.load(std::memory_order_relaxed);
    if (at - read_.load(std::memory_order_acquire) == slots_.size()) {
      lost_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    slots_[at & (slots_.size() - 1)] = value;
    written_.store(at + 1, std::memory_order_release);
    return true;
  }
  /// Writer: whether push() would drop its value.
  bool full() const noexcept { return written_.load(std::memory_order_relaxed) - read_.load(std::memory_order_acquire) == slots_.size(); }

  /// Reader: passes all values to `take`, in order, then frees their slots. Returns their number.
  template <class Take>
  std::size_t drain(const Take& take) {
    const std::uint64_t begin = read_.load(std::memory_order_relaxed), end = written_.load(std::memory_order_acquire);
    for (std::uint64_t at = begin; at != end; ++at) take(slots_[at & (slots_.size() - 1)]);
    read_.store(end, std::memory_order_release);
    return end - begin;
  }

  /// Number of values dropped so far. May be called from any thread.
  std::uint64_t lost() const noexcept { return lost_.load(std::memory_order_relaxed); }

 private:
  std::vector<Value> slots_;
  alignas(64) std::atomic<std::uint64_t> written_{0};  // values since the start
  alignas(64) std::atomic<std::uint64_t> read_{0};     // "
  alignas(64) std::atomic<std::uint64_t> lost_{0};
};

}  // namespace spheretree::view
