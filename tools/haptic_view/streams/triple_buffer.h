// SPDX-License-Identifier: GPL-3.0-or-later
// The latest value from one thread to another, wait-free on both sides: the writer never waits for the reader, nor the
// reader for the writer, and the reader always sees a whole value.
//
// Three slots: one belongs to the writer, one to the reader, and one is between them. Either side swaps its own slot
// for the one between by a single exchange of an atomic byte. A seqlock would need less memory, but its reader may have
// to retry, and its payload would have to be atomic word by word.
#pragma once

#include <atomic>
#include <cstdint>
#include <type_traits>

namespace spheretree::view {

template <class Value>
class TripleBuffer {
  static_assert(std::is_copy_assignable_v<Value> && std::is_default_constructible_v<Value>);

 public:
  /// Writer: the slot to fill. It holds an older value, so that every part of it must be written.
  Value& back() noexcept { return slots_[back_].value; }
  /// Writer: hands the filled slot over; back() is then another one.
  void publish() noexcept { back_ = between_.exchange(static_cast<std::uint8_t>(back_ | kFresh), std::memory_order_acq_rel) & kIndex; }
  void publish(const Value& value) noexcept {
    back() = value;
    publish();
  }

  /// Reader: takes the newest value over. False, and front() stays, if there is none since the last time.
  bool refresh() noexcept {
    if (!(between_.load(std::memory_order_relaxed) & kFresh)) return false;
    front_ = between_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    return true;
  }
  /// Reader: the value of the last refresh().
  const Value& front() const noexcept { return slots_[front_].value; }

 private:
  static constexpr std::uint8_t kIndex = 3, kFresh = 4;  // of between_: which slot, and whether the writer put it there
  static_assert(std::atomic<std::uint8_t>::is_always_lock_free);
  struct alignas(64) Slot {  // writer and reader do not share a cache line
    Value value{};
  };
  Slot slots_[3];
  alignas(64) std::atomic<std::uint8_t> between_{1};
  alignas(64) std::uint8_t back_ = 0;   // of the writer
  alignas(64) std::uint8_t front_ = 2;  // of the reader
};

}  // namespace spheretree::view
