// SPDX-License-Identifier: GPL-3.0-or-later
// From labelled scans of one or two jaws to solids, a scene and a report: the implementation of `spheretree split`.
// Units: mm.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/split/scan_input.h"
#include "spheretree/builder/progress.h"
#include "split/split_scan.h"

namespace spheretree::pipeline {

struct SplitJobSettings {
  std::vector<std::filesystem::path> scans;   // one or two
  std::vector<std::filesystem::path> labels;  // JSON, one for each scan; or empty, if `source` is used
  LabelSource source;                         // its `file` is unused
  std::filesystem::path folder;               // of the results; made if it is missing
  std::filesystem::path marked;               // GLB with the invented triangles marked; "": none
  std::string unit;                           // of the scans; "": mm, glTF m
  std::string jaw = "auto";                   // upper, lower, auto
  std::string frame;                          // "LPS" or "RAS": scans that state the other one are turned; "": none
  std::optional<double> opening_deg;          // angle by which the lower of two jaws is opened
  builder::SplitSettings split;
};

struct SplitJobResult {
  nlohmann::ordered_json report;    // schema spheretree.split/1: docs/split.md
  std::size_t teeth = 0, gums = 0;  // written
  std::size_t refused = 0;          // parts that are not closed or intersect themselves; they are not written
  std::size_t crossing = 0;         // written parts that cross another part
  std::vector<std::string> notes;   // whole sentences
};

/// Writes NAME.ply for each part, mouth.scene.json, split.json, a ball as tool, and the marked GLB.
/// @throws tool::UsageError for incompatible settings or an output that would replace an input; formats::FileError,
/// formats::FormatError for the files; builder::BuildError if there is nothing to cut; Cancelled.
SplitJobResult runSplit(const SplitJobSettings& settings, builder::Progress& progress);

}  // namespace spheretree::pipeline
