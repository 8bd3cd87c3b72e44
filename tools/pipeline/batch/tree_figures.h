// SPDX-License-Identifier: GPL-3.0-or-later
// The figures of a tree that a batch built or read, and their JSON: the entries of `objects[]` in report.json and the
// records of the cache. They depend only on the mesh and the settings, not on the clock, the machine or the number of
// threads.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "spheretree/builder/evaluation.h"
#include "spheretree/core/sphere_tree.h"

namespace spheretree::pipeline {

/// Version of these figures as records of the cache; part of the key of a record.
inline constexpr const char* kRecordSchema = "spheretree.batch-record/2";

struct LevelFigures {
  int level = 0;
  std::size_t spheres = 0;
  std::optional<double> overhang_bound_mm;           // proven; empty: the tree has no bound
  std::optional<builder::LevelEvaluation> measured;  // empty for a tree that came as a file
};

/// The figures of an object in a region of work.
struct WorkFigures {
  std::string name;
  double tolerance_mm = 0;
  std::size_t triangles = 0;     // of the object, in the region
  double overhang_bound_mm = 0;  // proven: no leaf reaches farther out of the object through these triangles
};

/// For a tree whose number of leaves was chosen by a budget: how its overhang compares with its tolerances.
struct ToleranceRatio {
  double ratio = 0;                  // proven overhang as a multiple of the tolerance (of 1 mm without one). Graded: the largest multiple
  std::optional<double> min_met_mm;  // graded: the smallest tolerance_mm of the object that its leaves meet
};

/// A repair step that changed the mesh before the build.
struct RepairFigures {
  std::string step;  // builder::name()
  std::string text;  // one sentence for people
  std::size_t count = 0, removed_triangles = 0;
  double change_mm = 0;  // largest motion of the surface; of a filling: its largest distance from the previous surface
};

struct TreeFigures {
  std::size_t triangles = 0, leaves = 0, nodes = 0;
  double diagonal_mm = 0;
  std::optional<double> tolerance_mm;  // empty: the builder used all allowed leaves
  std::optional<bool> tolerance_met;   // if there is a tolerance
  bool certified = false;
  std::size_t input_triangles = 0;  // before the repair; 0 for a tree that came as a file
  std::vector<RepairFigures> repair;
  std::vector<std::string> notes;  // of the mesh reader
  std::vector<LevelFigures> levels;
  std::optional<ToleranceRatio> ratio;
  std::optional<builder::SkinEvaluation> skin;   // stated in a tree that has a skin
  std::optional<double> min_tolerance_mm;        // graded: the smallest tolerance of any triangle
  std::optional<std::vector<WorkFigures>> work;  // if the scene has regions of work

  /// Largest motion of the surface by the repair; 0 without a repair.
  double repairChange() const;
  /// Number of triangles of the input that the repair left out.
  std::size_t removedTriangles() const;
  /// Whether the repair moved the surface by more than the tolerance or 1 % of the diagonal.
  bool isChangeLarge() const;
  /// Whether it left out more than a tenth of the triangles, which may be a part that the user needs, even if the
  /// surface around them did not move.
  bool isLossLarge() const;
  /// Whether the user should check the repair.
  bool isRepairLarge() const { return isChangeLarge() || isLossLarge(); }
  bool isGraded() const { return min_tolerance_mm.has_value(); }
  /// Proven overhang bound of the leaves; 0 if there is none.
  double leafBound() const { return levels.empty() ? 0 : levels.back().overhang_bound_mm.value_or(0); }
};

/// The figures that a tree from a file contains.
TreeFigures figuresOf(const SphereTree& tree);

nlohmann::ordered_json toJson(const TreeFigures& figures);

/// @throws nlohmann::json::exception if a key is missing or of another type.
TreeFigures treeFiguresFromJson(const nlohmann::ordered_json& json);

}  // namespace spheretree::pipeline
