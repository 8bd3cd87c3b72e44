// SPDX-License-Identifier: GPL-3.0-or-later
// Compares builders and qualities on some meshes: the implementation of `spheretree compare`. Its figures:
// comparison_figures.h; to and from JSON: comparison_json.h
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/comparison/comparison_figures.h"
#include "spheretree/builder/build_settings.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/sphere_tree.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::pipeline {

/// Every builder with every quality that changes its result. The octree has no qualities and appears once, with
/// standard if that is listed, otherwise with the first one. Duplicates are removed.
std::vector<Method> methods(const std::vector<NamedBuilder>& builders, const std::vector<builder::Quality>& qualities);

/// Spheres that another program computed for a mesh.
struct OtherSpheres {
  std::string name;            // unique for the mesh
  std::filesystem::path file;  // absolute
  std::string format;          // "cuRobo", "foam", ...
  SphereTree level;            // all spheres, as the only level of a tree
  double seconds = 0;          // of processor time that the program took; 0: unknown
};

/// A mesh to compare on.
struct ComparedMesh {
  std::string name;            // unique, part of file names
  std::filesystem::path file;  // absolute
  double unit_mm = 1;          // unit in which it was read
  TriangleMesh mesh;           // sound
  TriangleMesh to_cover;       // surface that repair removed from `mesh`, but that trees still cover
  std::vector<OtherSpheres> others = {};
};

struct ComparisonSettings {
  std::vector<Method> methods;
  builder::BuildSettings build;  // levels, branching, seed, threads; the other settings come from each method
  int rotations = 0;             // > 0: also measure the sensitivity, with this number of rotations of each mesh
  std::filesystem::path folder;  // of the results; it may be that of an interrupted run
};

/// Builds and measures what is not yet in the folder: a tree in trees/ and figures in runs/, named
/// MESH.BUILDER.QUALITY, and limits in runs/MESH. A failed run is part of the result and does not stop the others.
/// Writes compare.csv and compare.json at the end.
/// @throws builder::Cancelled: finished runs are in the folder; formats::FileError.
Comparison runComparison(const std::vector<ComparedMesh>& meshes, const ComparisonSettings& settings, builder::Progress& progress);

/// One line for each level of each run, and for each file of other spheres, with its name in the column of the builder
/// and without quality and seconds.
std::string comparisonCsv(const Comparison& comparison);

}  // namespace spheretree::pipeline
