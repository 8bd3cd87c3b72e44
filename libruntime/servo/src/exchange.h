// SPDX-License-Identifier: Apache-2.0
// Values between the threads of an engine and of the servo loop, without locks.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace spheretree::servo {

/// N numbers of one writer, for any readers: a reader that met a write reads again.
template <std::size_t N>
class SeqLock {
 public:
  void write(const std::array<double, N>& values) noexcept {
    const std::uint32_t version = version_.load(std::memory_order_relaxed);
    version_.store(version + 1, std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_release);
    for (std::size_t n = 0; n < N; ++n) values_[n].store(values[n], std::memory_order_relaxed);
    version_.store(version + 2, std::memory_order_release);
  }
  /// Returns the number of the version that it read; 0, with no values, if there is none yet or while a write goes on:
  /// the servo loop does not wait for it.
  std::uint32_t read(std::array<double, N>& values) const noexcept {
    const std::uint32_t before = version_.load(std::memory_order_acquire);
    for (std::size_t n = 0; n < N; ++n) values[n] = values_[n].load(std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_acquire);
    return before % 2 == 0 && version_.load(std::memory_order_relaxed) == before ? before : 0;
  }

 private:
  std::atomic<std::uint32_t> version_{0};
  std::array<std::atomic<double>, N> values_{};
};

/// The newest value of one writer, for one reader; neither ever waits.
template <class Value>
class TripleBuffer {
 public:
  Value& back() noexcept { return values_[back_]; }
  void publish() noexcept { back_ = middle_.exchange(back_ | kNew, std::memory_order_acq_rel) & kIndex; }
  const Value& front() const noexcept { return values_[front_]; }
  void refresh() noexcept {
    if (middle_.load(std::memory_order_relaxed) & kNew) front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
  }

 private:
  static constexpr unsigned kNew = 4, kIndex = 3;
  std::array<Value, 3> values_{};
  unsigned back_ = 0, front_ = 2;
  std::atomic<unsigned> middle_{1};
};

}  // namespace spheretree::servo
