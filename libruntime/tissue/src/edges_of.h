// SPDX-License-Identifier: Apache-2.0
// The edges of tetrahedra, without repetition.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace spheretree::tissue {

struct EdgeList {
  std::size_t count = 0;
  std::vector<std::array<std::uint32_t, 6>> of_element;  // indices of the edges 01, 02, 03, 12, 13, 23
};

inline EdgeList edgesOf(std::span<const std::array<std::uint32_t, 4>> corners) {
  constexpr std::array<std::pair<std::size_t, std::size_t>, 6> kEnds{{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};
  const auto edge = [&](const std::array<std::uint32_t, 4>& c, std::size_t k) {
    return std::pair<std::uint32_t, std::uint32_t>(std::minmax(c[kEnds[k].first], c[kEnds[k].second]));
  };
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ends;
  for (const auto& c : corners)
    for (std::size_t k = 0; k < 6; ++k) ends.push_back(edge(c, k));
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  EdgeList out{ends.size(), {}};
  for (const auto& c : corners) {
    auto& list = out.of_element.emplace_back();
    for (std::size_t k = 0; k < 6; ++k)
      list[k] = static_cast<std::uint32_t>(std::lower_bound(ends.begin(), ends.end(), edge(c, k)) - ends.begin());
  }
  return out;
}

}  // namespace spheretree::tissue
