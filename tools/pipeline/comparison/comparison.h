// SPDX-License-Identifier: GPL-3.0-or-later
// Builders and qualities against each other on some meshes: what `spheretree compare` calls, and its figures.
// compare.json is these and nothing else (schema spheretree.comparison/1); JSON in and out: comparison_json.h
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "spheretree/builder/build_settings.h"
#include "spheretree/builder/evaluation.h"
#include "spheretree/builder/progress.h"
#include "spheretree/builder/sensitivity.h"
#include "spheretree/core/sphere_tree.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::pipeline {

/// A builder in one of its qualities.
struct Method {
  builder::BuilderKind builder = builder::BuilderKind::Cover;
  builder::Quality quality = builder::Quality::Standard;
  friend bool operator==(const Method&, const Method&) = default;
};

/// "cover.standard"
std::string idOf(const Method& method);

/// Every builder in every quality that changes its result: the octree has none and stands once, as standard or else the
/// first. What is named twice stands once.
std::vector<Method> methods(const std::vector<builder::BuilderKind>& builders, const std::vector<builder::Quality>& qualities);

/// Spheres that another program made for a mesh.
struct OtherSpheres {
  std::string name;            // unique for the mesh
  std::filesystem::path file;  // absolute
  std::string format;          // "cuRobo", "foam", ...
  SphereTree level;            // all of them, as the one level of a tree
};

/// A mesh to compare on.
struct ComparedMesh {
  std::string name;            // unique, part of file names
  std::filesystem::path file;  // absolute
  double unit_mm = 1;          // that it was read in
  TriangleMesh mesh;           // sound
  TriangleMesh to_cover;       // what repair has taken out of `mesh` and trees cover all the same
  std::vector<OtherSpheres> others = {};
};

/// By the measures of every level of a tree; how long they took to make is not known.
struct OtherFigures {
  std::string name;
  std::filesystem::path file;
  std::string format;
  builder::LevelEvaluation level;
};

struct MeshFigures {
  std::string name;
  std::filesystem::path file;
  double unit_mm = 1;
  std::size_t triangles = 0;
  double diagonal_mm = 0, area_mm2 = 0, volume_mm3 = 0;
  double leaves = 0;            // that a full tree has: the limits are for as many spheres
  builder::CoverLimits limits;  // on the overhang of any cover
  std::vector<OtherFigures> others = {};
};

/// One tree of one mesh.
struct Run {
  std::string mesh;
  Method method;
  std::string error;           // why it failed; empty: it was built, and the rest is set
  std::filesystem::path tree;  // in the folder of the comparison
  double seconds = 0, processor_seconds = 0;
  std::size_t nodes = 0;
  std::vector<builder::LevelEvaluation> levels;
  builder::HierarchyEvaluation hierarchy;
  bool isBuilt() const { return error.empty(); }
};

/// How much the tree of one method changes when its mesh changes in ways that should not matter.
struct Sensitivity {
  std::string mesh;
  Method method;
  std::string error;  // why no tree can be built; empty: `rows` are set
  std::vector<builder::SensitivityRow> rows;
};

/// Figures of the leaves of a run, lengths in per cent of the mesh's diagonal; or geometric means of them.
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

struct ComparisonSettings {
  std::vector<Method> methods;
  builder::BuildSettings build;  // levels, branching, seed, threads; the rest comes from each method
  int rotations = 0;             // > 0: also measure the sensitivity, with this number of rotations of each mesh
  std::filesystem::path folder;  // of the results; it may be that of a run that was stopped
};

/// Builds and measures what the folder does not hold yet: a tree in trees/ and figures in runs/, named
/// MESH.BUILDER.QUALITY, and limits in runs/MESH. A run that fails is part of the result and does not stop the others.
/// Writes compare.csv and compare.json at the end.
/// @throws builder::Cancelled: finished runs are in the folder; formats::FileError.
Comparison runComparison(const std::vector<ComparedMesh>& meshes, const ComparisonSettings& settings, builder::Progress& progress);

/// Of a run that was built. @throws formats::FormatError if `comparison` has no mesh of its name.
LeafFigures leafFigures(const Comparison& comparison, const Run& run);

/// For each method with a tree for every mesh, in the order of the runs.
std::vector<MeanFigures> geometricMeans(const Comparison& comparison);

/// One line for each level of each run, and for each file of other spheres: its name in place of the builder, without
/// quality and seconds.
std::string comparisonCsv(const Comparison& comparison);

}  // namespace spheretree::pipeline
