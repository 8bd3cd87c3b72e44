// SPDX-License-Identifier: GPL-3.0-or-later
// The figures of a tree that a batch built or read, and their JSON: the entries of `objects[]` in report.json and the
// records of the cache. They depend on nothing but the mesh and the settings: not on the clock, the machine or the
// number of threads.
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

/// A step that changed the mesh before the build.
struct RepairFigures {
  std::string step;  // builder::name()
  std::string text;  // a sentence for people
  std::size_t count = 0, removed_triangles = 0;
  double change_mm = 0;  // how far the surface moved at most; of a filling: how far it lies from what was there
};

struct TreeFigures {
  std::size_t triangles = 0, leaves = 0, nodes = 0;
  double diagonal_mm = 0;
  std::optional<double> tolerance_mm;  // none: the whole budget of leaves was used
  std::optional<bool> tolerance_met;   // with a tolerance
  bool certified = false;
  std::size_t input_triangles = 0;  // before the repair; 0 for a tree that came as a file
  std::vector<RepairFigures> repair;
  std::vector<std::string> notes;  // of the reader of the mesh
  std::vector<LevelFigures> levels;
  std::optional<ToleranceRatio> ratio;
  std::optional<builder::SkinEvaluation> skin;   // of a tree that has one: what it states
  std::optional<double> least_tolerance_mm;      // graded: the smallest tolerance of any triangle
  std::optional<std::vector<WorkFigures>> work;  // with regions of work in the scene

  /// How far the repair moved the surface at most; 0 without one.
  double repairChange() const;
  /// Whether the repair changed more than a user may take for granted: by more than the tolerance or a hundredth of the
  /// diagonal.
  bool isRepairLarge() const;
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
