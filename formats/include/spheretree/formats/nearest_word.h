// SPDX-License-Identifier: Apache-2.0
// "Did you mean ...?" for a mistyped key, verb or option.
#pragma once

#include <algorithm>
#include <numeric>
#include <string_view>
#include <vector>

namespace spheretree::formats {

/// Letters to insert, drop or change until `a` is `b` (Levenshtein).
inline std::size_t editDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t change = diagonal + (a[i] != b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min({change, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

/// The word of `known` (not empty) with the least edit distance to `word`; the first of several.
template <class Words>
std::string_view nearestWord(std::string_view word, const Words& known) {
  return *std::min_element(std::begin(known), std::end(known),
                           [&](std::string_view a, std::string_view b) { return editDistance(word, a) < editDistance(word, b); });
}

}  // namespace spheretree::formats
