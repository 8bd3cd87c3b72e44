// SPDX-License-Identifier: GPL-3.0-or-later
// Transfers the latest value from one thread to another, wait-free on both sides: neither thread waits for the other,
// and the reader always sees a complete value.
//
// There are three slots: one belongs to the writer, one to the reader, and one is in between. Each side exchanges its
// own slot with the one in between by a single exchange of an atomic byte. A seqlock would need less memory, but its
// reader might have to retry, and its payload would have to be atomic word by word.
#pragma once

#include <atomic>
#include <cstdint>
#include <type_traits>

namespace spheretree::view {

template <class Value>
class TripleBuffer {
  static_assert(std::is_copy_assignable_v<Value> && std::is_default_constructible_v<Value>);

 public:
  /// Writer: the slot to fill. It holds an older value, so every part of it must be written.
  Value& back() noexcept { return slots_[back_].value; }
  /// Writer: publishes the filled slot; back() then returns another one.
  void publish() noexcept { back_ = between_.exchange(static_cast<std::uint8_t>(back_ | kFresh), std::memory_order_acq_rel) & kIndex; }
  void publish(const Value& value) noexcept {
    back() = value;
    publish();
  }

  /// Reader: takes the newest value. Returns false, and keeps front(), if there is no new one.
  bool refresh() noexcept {
    if (!(between_.load(std::memory_order_relaxed) & kFresh)) return false;
    front_ = between_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    return true;
  }
  /// Reader: the value of the last refresh().
  const Value& front() const noexcept { return slots_[front_].value; }

 private:
  static constexpr std::uint8_t kIndex = 3, kFresh = 4;  // of between_: index of the slot, and whether the writer put it there
  static_assert(std::atomic<std::uint8_t>::is_always_lock_free);
  struct alignas(64) Slot {  // separate cache lines for writer and reader
    Value value{};
  };
  Slot slots_[3];
  alignas(64) std::atomic<std::uint8_t> between_{1};
  alignas(64) std::uint8_t back_ = 0;   // of the writer
  alignas(64) std::uint8_t front_ = 2;  // of the reader
};

}  // namespace spheretree::view
