// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/mode.h"

#include <algorithm>
#include <stdexcept>

namespace spheretree::player {

std::string_view name(Mode mode) {
  switch (mode) {
    case Mode::Published:
      return "paper";
    case Mode::Constrained:
      return "constrained";
    case Mode::Points:
      return "points";
    case Mode::Volume:
      return "volume";
    case Mode::Continuous:
      break;
  }
  return "continuous";
}

std::vector<Mode> modesOf(const std::string& list) {
  std::vector<Mode> chosen;
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    const std::string word = list.substr(begin, end - begin);
    const auto found = std::find_if(kModes.begin(), kModes.end(), [&](Mode mode) { return name(mode) == word; });
    if (found == kModes.end())
      throw std::invalid_argument("no mode is called '" + word + "'. There are: paper, constrained, points, volume, continuous.");
    chosen.push_back(*found);
    begin = end + 1;
  }
  std::sort(chosen.begin(), chosen.end());
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  return chosen;
}

}  // namespace spheretree::player
