// SPDX-License-Identifier: GPL-3.0-or-later
// The figures of a comparison, which are the whole content of compare.json (schema spheretree.comparison/1).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/builder_names.h"
#include "spheretree/builder/build_settings.h"
#include "spheretree/builder/evaluation.h"
#include "spheretree/builder/sensitivity.h"

namespace spheretree::pipeline {

/// A builder, with the search or without, and one quality.
struct Method {
  NamedBuilder builder;
  builder::Quality quality = builder::Quality::Standard;
  friend bool operator==(const Method&, const Method&) = default;
};

/// For example "cover.standard".
std::string idOf(const Method& method);

/// Other spheres with the measures that every level of a tree gets.
struct OtherFigures {
  std::string name;
  std::filesystem::path file;
  std::string format;
  builder::LevelEvaluation level;
  double seconds = 0;  // of processor time; 0: unknown
};

struct MeshFigures {
  std::string name;
  std::filesystem::path file;
  double unit_mm = 1;
  std::size_t triangles = 0;
  double diagonal_mm = 0, area_mm2 = 0, volume_mm3 = 0;
  double leaves = 0;            // number of leaves of a full tree, for which the limits are computed
  builder::CoverLimits limits;  // limits on the overhang of any cover
  std::vector<OtherFigures> others = {};
};

/// One tree of one mesh.
struct Run {
  std::string mesh;
  Method method;
  std::string error;           // reason for a failure; empty: the tree was built, and the other members are set
  std::filesystem::path tree;  // relative to the folder of the comparison
  double seconds = 0, processor_seconds = 0;
  std::size_t nodes = 0;
  std::vector<builder::LevelEvaluation> levels;
  builder::HierarchyEvaluation hierarchy;
  bool isBuilt() const { return error.empty(); }
};

/// How much the tree of one method changes under changes of its mesh that should not matter.
struct Sensitivity {
  std::string mesh;
  Method method;
  std::string error;  // why no tree can be built; empty: `rows` are set
  std::vector<builder::SensitivityRow> rows;
};

/// Figures of the leaves of a run, with lengths in per cent of the mesh's diagonal; or geometric means of such figures.
struct LeafFigures {
  double processor_seconds = 0, seconds = 0, overhang_percent = 0, p99_percent = 0, excess_percent = 0;
};

struct MeanFigures {
  Method method;
  LeafFigures figures;
};

struct Comparison {
  std::string generator, processor;
  int threads = 0;
  int levels = 0, branching = 0;
  std::uint64_t seed = 0;
  std::vector<MeshFigures> meshes;
  std::vector<Run> runs;
  std::optional<std::vector<Sensitivity>> sensitivity;
  std::vector<MeanFigures> means;
};

/// The leaf figures of a successful run. @throws formats::FormatError if `comparison` does not have its mesh.
LeafFigures leafFigures(const Comparison& comparison, const Run& run);

/// One entry for each method that has a tree for every mesh, in the order of the runs.
std::vector<MeanFigures> geometricMeans(const Comparison& comparison);

}  // namespace spheretree::pipeline
