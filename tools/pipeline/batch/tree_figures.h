// SPDX-License-Identifier: GPL-3.0-or-later
// The figures of a tree that a batch built or read, and their JSON: the entries of `objects[]` in report.json and the records of the
// cache. They depend on nothing but the mesh and the settings: not on the clock, the machine or the number of threads.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "spheretree/builder/evaluation.h"
#include "spheretree/core/sphere_tree.h"

namespace spheretree::pipeline {

struct LevelFigures {
  int level = 0;
  std::size_t spheres = 0;
  std::optional<double> overhang_bound_mm;           // proven; none: the tree says nothing of it
  std::optional<builder::LevelEvaluation> measured;  // none for a tree that came as a file
};

/// What a leaf may do within a region of work.
struct WorkFigures {
  std::string name;
  double tolerance_mm = 0;
  std::size_t triangles = 0;     // of the object, within the region
  double overhang_bound_mm = 0;  // proven: no leaf reaches farther out of the object through these triangles
};

/// Of a tree whose number of leaves was chosen for it (a budget): how near it comes to its tolerances.
struct ToleranceRatio {
  double ratio = 0;  // proven overhang as a multiple of the tolerance; of 1 mm without one. Graded: the largest multiple of all
  std::optional<double> least_met_mm;  // graded: the smallest tolerance of the object that its leaves meet
};

struct TreeFigures {
  std::size_t triangles = 0, leaves = 0, nodes = 0;
  double diagonal_mm = 0;
  std::optional<double> tolerance_mm;  // none: the whole budget of leaves was used
  std::optional<bool> tolerance_met;   // with a tolerance
  bool certified = false;
  std::vector<std::string> repair;  // a sentence for each step that changed the mesh
  std::vector<std::string> notes;   // of the reader of the mesh
  std::vector<LevelFigures> levels;
  std::optional<ToleranceRatio> ratio;
  std::optional<double> least_tolerance_mm;      // graded: the smallest tolerance of any triangle
  std::optional<std::vector<WorkFigures>> work;  // with regions of work in the scene

  bool isGraded() const { return least_tolerance_mm.has_value(); }
  /// Proven overhang of the leaves; 0 where nothing is proven.
  double leafBound() const { return levels.empty() ? 0 : levels.back().overhang_bound_mm.value_or(0); }
};

/// Of a tree that came as a file: what it says of itself.
TreeFigures figuresOf(const SphereTree& tree);

nlohmann::ordered_json toJson(const TreeFigures& figures);

/// @throws nlohmann::json::exception if a key is missing or of another type.
TreeFigures treeFiguresFromJson(const nlohmann::ordered_json& json);

}  // namespace spheretree::pipeline
