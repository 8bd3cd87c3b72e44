// SPDX-License-Identifier: Apache-2.0
// Names of files as text.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace spheretree::formats {

/// A path from its name in UTF-8, and back, with / between folders: what files, messages and command lines hold. On
/// POSIX a name is any bytes, which are kept.
inline std::filesystem::path toPath(std::string_view name) {
  return {std::u8string_view(reinterpret_cast<const char8_t*>(name.data()), name.size())};
}
inline std::string toUtf8(const std::filesystem::path& path) {
  const std::u8string name = path.generic_u8string();
  return {reinterpret_cast<const char*>(name.data()), name.size()};
}

}  // namespace spheretree::formats
