// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/tree_input.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "program_end.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/sph_text.h"
#include "spheretree/formats/sphere_tree_file.h"
#include "spheretree/formats/tree_json.h"

namespace spheretree::tool {

std::string endingOf(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return ending;
}

SphereTree readTree(const std::filesystem::path& path) {
  const std::string ending = endingOf(path);
  if (ending == ".stree") return formats::readSphereTree(path);
  if (ending != ".sph" && ending != ".json") throw UsageError(path.string() + ": the tree's name must end in .stree, .sph or .json.");
  constexpr std::uint64_t kMostBytes = 64 << 20;  // a full tree takes less than 10 MB
  const std::vector<std::byte> bytes = formats::readFile(path, kMostBytes);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return ending == ".sph" ? formats::parseSph(text, path.string()) : formats::parseTreeJson(text, path.string());
}

}  // namespace spheretree::tool
