// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/tissue/states_file.h"

#include <charconv>
#include <cmath>

#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"

namespace spheretree::pipeline {
namespace {

constexpr std::string_view kHeader = "state,node,dx_mm,dy_mm,dz_mm";
constexpr double kFarthest = 1e6;  // [mm]

/// The next field of `line` as a number; false if it is none.
template <class T>
bool take(std::string_view& line, T& value) {
  const std::size_t end = std::min(line.find(','), line.size());
  const std::string_view field = line.substr(0, end);
  line.remove_prefix(std::min(end + 1, line.size()));
  const auto [last, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  return error == std::errc() && last == field.data() + field.size();
}

}  // namespace

std::vector<builder::TissueState> readStates(const std::filesystem::path& path, std::size_t nodes) {
  const std::vector<std::byte> bytes = formats::readFile(path);
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  std::vector<builder::TissueState> states;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    const auto fail = [&](const std::string& what) {
      throw formats::FormatError(formats::shownName(path) + ", line " + std::to_string(number) + ": " + what);
    };
    if (number == 1) {
      if (line != kHeader) fail("the header must be " + std::string(kHeader));
      continue;
    }
    if (line.empty()) continue;
    std::size_t state = 0, node = 0;
    Eigen::Vector3d d;
    if (!take(line, state) || !take(line, node) || !take(line, d.x()) || !take(line, d.y()) || !take(line, d.z()) || !line.empty())
      fail("a row is state,node,dx_mm,dy_mm,dz_mm");
    if (state >= kMaxStates) fail("there can be " + std::to_string(kMaxStates) + " states");
    if (state + 1 < states.size()) fail("state " + std::to_string(state) + " comes after a later one");
    if (node >= nodes) fail("node " + std::to_string(node) + " does not exist; there are " + std::to_string(nodes));
    if (!d.allFinite() || d.cwiseAbs().maxCoeff() > kFarthest) fail("a displacement is not finite, or beyond 1e6 mm");
    while (states.size() <= state)
      states.push_back({"file", static_cast<double>(states.size()), std::vector<Eigen::Vector3d>(nodes, Eigen::Vector3d::Zero())});
    states[state].displacements[node] = d;
  }
  if (states.empty())
    throw formats::FormatError(formats::shownName(path) + ": there is no state in it; begin with the line " + std::string(kHeader));
  return states;
}

}  // namespace spheretree::pipeline
