// SPDX-License-Identifier: Apache-2.0
// Pairs of balls that a search has found, in the memory of a step.
#pragma once

#include <cstdint>
#include <span>

namespace spheretree::runtime {

/// Consecutive pairs of one object. Pair: tool slot << 16 | object slot.
struct PairRun {
  std::uint32_t object, begin, count;
  bool of_wall = false;  // the slots are those of the walls of what was cut off (state/cutting.h)
};

struct PairSet {
  std::span<const std::uint32_t> pairs;
  std::span<const PairRun> runs;
  bool coarse = false;     // the lists or the work ran out: some pairs are inner nodes, whose spheres replace everything below them
  std::uint32_t work = 0;  // 8-lane tests done
};

/// Upper bound of the float rounding error of a distance, relative to the lengths involved: at most 12 roundings of
/// 2^-24 each on either side.
inline constexpr double kFloatRounding = 1e-6;

}  // namespace spheretree::runtime
