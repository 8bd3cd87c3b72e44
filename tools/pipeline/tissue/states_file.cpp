// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/tissue/states_file.h"

#include <array>

#include "spheretree/formats/csv_table.h"
#include "spheretree/formats/file_io.h"

namespace spheretree::pipeline {
namespace {

constexpr std::array kColumns{"state", "node", "dx_mm", "dy_mm", "dz_mm"};
constexpr double kFarthest = 1e6;  // [mm]

}  // namespace

std::vector<builder::TissueState> readStates(const std::filesystem::path& path, std::size_t nodes) {
  const std::vector<std::byte> bytes = formats::readFile(path);
  formats::CsvTable table({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, formats::shownName(path));
  std::array<std::size_t, kColumns.size()> at{};
  for (std::size_t c = 0; c < at.size(); ++c) at[c] = table.require(kColumns[c], "begin with the line state,node,dx_mm,dy_mm,dz_mm");
  std::vector<builder::TissueState> states;
  while (table.next()) {
    const std::size_t state = table.count(at[0], kMaxStates - 1), node = table.count(at[1], nodes - 1);
    if (state + 1 < states.size()) table.failField(at[0], "it comes after a later one; write the states in order");
    while (states.size() <= state)
      states.push_back({"file", static_cast<double>(states.size()), std::vector<Eigen::Vector3d>(nodes, Eigen::Vector3d::Zero())});
    states[state].displacements[node] = {table.number(at[2], kFarthest), table.number(at[3], kFarthest), table.number(at[4], kFarthest)};
  }
  if (states.empty()) table.fail("no state after the header");
  return states;
}

}  // namespace spheretree::pipeline
