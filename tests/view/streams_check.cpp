// SPDX-License-Identifier: GPL-3.0-or-later
// streams_check COUNT: sends COUNT values through each stream between two threads, ten times as many with
// SPHERETREE_LONG=1, and reports values that were torn, came out of order, or were lost without being counted. Exit
// code 1 if there is one. It is also built with ThreadSanitizer, which ends it at the first race.
#include <array>
#include <atomic>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "streams/step_ring.h"
#include "streams/triple_buffer.h"

namespace {

using spheretree::view::StepRing;
using spheretree::view::TripleBuffer;

/// The size of a state with a few contacts. Every word depends on the number, so that a mixture of two values is
/// detected.
struct Numbered {
  static constexpr std::size_t kWords = 40;
  std::uint64_t number = 0;
  std::array<std::uint64_t, kWords> words{};

  static std::uint64_t word(std::uint64_t number, std::size_t k) { return (number + k) * 0x9e3779b97f4a7c15u; }
  void fill(std::uint64_t n) {
    number = n;
    for (std::size_t k = 0; k < kWords; ++k) words[k] = word(n, k);
  }
  bool isWhole() const {
    for (std::size_t k = 0; k < kWords; ++k)
      if (words[k] != word(number, k)) return false;
    return true;
  }
};

struct Tally {
  std::uint64_t seen = 0, torn = 0, backwards = 0, missing = 0;
  bool isClean() const { return torn == 0 && backwards == 0 && missing == 0 && seen > 0; }
};

/// Yields the processor now and then: with a single processor, the other thread must get it.
class Waiting {
 public:
  void wait() {
    if (++spins_ % 256 == 0) std::this_thread::yield();
  }

 private:
  unsigned spins_ = 0;
};

Tally checkTripleBuffer(std::uint64_t count) {
  constexpr std::uint64_t kLead = 8;  // values by which the writer may be ahead: otherwise a slow reader would receive only a few
  TripleBuffer<Numbered> buffer;
  std::atomic<std::uint64_t> seen{0};
  std::thread writer([&] {
    Waiting waiting;
    for (std::uint64_t n = 1; n <= count; ++n) {
      while (n > seen.load(std::memory_order_relaxed) + kLead) waiting.wait();
      buffer.back().fill(n);
      buffer.publish();
    }
  });
  Waiting waiting;
  Tally tally;
  for (std::uint64_t last = 0; last < count;) {  // the last value must arrive
    if (!buffer.refresh()) {
      waiting.wait();
      continue;
    }
    const Numbered& value = buffer.front();
    ++tally.seen;
    tally.torn += !value.isWhole();
    tally.backwards += value.number <= last;
    last = value.number;
    seen.store(last, std::memory_order_relaxed);
  }
  writer.join();
  return tally;
}

Tally checkRing(std::uint64_t count) {
  StepRing<Numbered> ring(256);
  std::thread writer([&] {
    Numbered value;
    Waiting waiting;
    for (std::uint64_t n = 1; n <= count; ++n) {
      value.fill(n);
      ring.push(value);
      if (ring.full()) waiting.wait();  // at some times the reader keeps up, at others not
    }
  });
  Tally tally;
  std::uint64_t last = 0;
  const auto take = [&](const Numbered& value) {
    ++tally.seen;
    tally.torn += !value.isWhole();
    tally.backwards += value.number <= last;
    last = value.number;
  };
  while (tally.seen + ring.lost() < count)
    if (ring.drain(take) == 0) std::this_thread::yield();
  writer.join();
  ring.drain(take);
  tally.missing = tally.seen + ring.lost() == count ? 0 : 1;
  return tally;
}

bool report(const char* stream, const Tally& tally) {
  std::printf("%s: %llu seen, %llu torn, %llu going backwards, %llu not accounted for\n", stream,
              static_cast<unsigned long long>(tally.seen), static_cast<unsigned long long>(tally.torn),
              static_cast<unsigned long long>(tally.backwards), static_cast<unsigned long long>(tally.missing));
  return tally.isClean();
}

}  // namespace

int main(int argc, char** argv) {
  std::uint64_t count = argc == 2 ? std::strtoull(argv[1], nullptr, 10) : 0;
  if (std::getenv("SPHERETREE_LONG")) count *= 10;
  if (count == 0) {
    std::fprintf(stderr, "usage: streams_check COUNT\n");
    return 2;
  }
  const bool buffer_clean = report("triple buffer", checkTripleBuffer(count));
  const bool ring_clean = report("ring", checkRing(count));
  return buffer_clean && ring_clean ? 0 : 1;
}
