// SPDX-License-Identifier: GPL-3.0-or-later
// A scan with its labels, from files. Units: mm.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::pipeline {

/// The source of the labels of a scan: exactly one of these.
struct LabelSource {
  std::filesystem::path file;  // JSON, in the format of formats::readScanLabels()
  std::string property;        // of a PLY file: a scalar of the vertices or faces, or "colour"
  bool parts = false;          // the parts of the mesh file, by their names
  std::string numbering = "fdi";
  std::string side = "auto";              // whether labels belong to "vertices" or to "faces"; "auto": see docs/split.md
  std::optional<std::int32_t> gum_label;  // a label that is gum, beside 0
};

struct ScanInput {
  TriangleMesh mesh;
  std::vector<std::int32_t> labels;  // of each vertex: FDI number, 0 for gum, or a number that is not a tooth
  std::string jaw;                   // "upper" or "lower" according to the labels; "" if they do not specify it
  std::string space;                 // of formats::MeshFile
  std::vector<std::string> notes;    // whole sentences
};

/// `jaw`: "upper" or "lower" if the user says so, otherwise "auto".
/// @throws formats::FileError; formats::FormatError for labels that do not fit the mesh, with the place, and for parts
/// that are closed solids already; tool::UsageError for a numbering that the labels cannot have.
ScanInput readScan(const std::filesystem::path& scan, const std::string& unit, const LabelSource& source, const std::string& jaw);

}  // namespace spheretree::pipeline
