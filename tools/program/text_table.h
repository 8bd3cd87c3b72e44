// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace spheretree::tool {

/// Lines of text, in columns that are as wide as their widest cell; all lines have as many cells as the first.
inline std::string textTable(const std::vector<std::vector<std::string>>& lines) {
  std::string text;
  for (const std::vector<std::string>& line : lines) {
    for (std::size_t k = 0; k + 1 < line.size(); ++k) {
      std::size_t width = 0;
      for (const std::vector<std::string>& other : lines) width = std::max(width, other[k].size() + 2);
      text += line[k] + std::string(width - line[k].size(), ' ');
    }
    text += line.back() + "\n";
  }
  return text;
}

}  // namespace spheretree::tool
