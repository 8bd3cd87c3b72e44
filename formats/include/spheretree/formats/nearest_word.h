// SPDX-License-Identifier: Apache-2.0
// "Did you mean ...?" for a mistyped key, verb or option.
#pragma once

#include <algorithm>
#include <numeric>
#include <optional>
#include <string_view>
#include <vector>

namespace spheretree::formats {

/// Optimal string alignment distance: letters to insert, drop or replace, and neighbours to swap, that turn `a` into
/// `b`.
inline std::size_t editDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      row[j + 1] = std::min({last[j] + (a[i] != b[j]), row[j] + 1, last[j + 1] + 1});
      if (i > 0 && j > 0 && a[i] == b[j - 1] && a[i - 1] == b[j]) row[j + 1] = std::min(row[j + 1], before[j - 1] + 1);
    }
    before.swap(last);
    last.swap(row);
  }
  return last.back();
}

/// The word of `known` that was most likely intended: the shortest word that begins with `word`; otherwise the first
/// word with the smallest edit distance, if that is at most max(1, letters of `word` / 3). Empty if no word is that
/// close.
template <class Words>
std::optional<std::string_view> nearestWord(std::string_view word, const Words& known) {
  std::optional<std::string_view> best;
  if (word.size() >= 2)
    for (const std::string_view k : known)
      if (k.starts_with(word) && (!best || k.size() < best->size())) best = k;
  if (best) return best;
  std::size_t smallest = std::max<std::size_t>(1, word.size() / 3) + 1;
  for (const std::string_view k : known) {
    const std::size_t distance = editDistance(word, k);
    if (distance < smallest && distance < word.size()) {
      smallest = distance;
      best = k;
    }
  }
  return best;
}

}  // namespace spheretree::formats
