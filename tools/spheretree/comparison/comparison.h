// SPDX-License-Identifier: GPL-3.0-or-later
// Builders and qualities against each other on some meshes: the runs, and their figures as JSON (schema spheretree.comparison/1).
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::tool {

using Json = nlohmann::ordered_json;

struct ComparedMesh {
  std::string name;            // unique, part of file names
  std::filesystem::path file;  // absolute
  TriangleMesh mesh;           // sound
  TriangleMesh to_cover;       // of the file, what repair has taken out of `mesh` and trees cover all the same
};

struct Method {
  builder::BuilderKind builder;
  builder::Quality quality;
};

/// Every builder in every quality that changes its result: the octree has none and stands once, as standard or else the first.
/// What is named twice stands once.
std::vector<Method> methods(const std::vector<builder::BuilderKind>& builders, const std::vector<builder::Quality>& qualities);

/// Builds and measures what `folder` does not hold yet: a tree in trees/ and figures in runs/, named MESH.BUILDER.QUALITY. A run that
/// fails is part of the result and does not stop the others. The folder may be that of a run that was killed. `settings`: levels,
/// branching, seed, threads.
/// @throws builder::Cancelled, formats::FileError.
Json compareBuilders(const std::vector<ComparedMesh>& meshes, const std::vector<Method>& what, const builder::BuildSettings& settings,
                     const std::filesystem::path& folder, builder::Progress& progress);

/// How much the trees of `what` change when their mesh changes in ways that should not matter (`builder::measureSensitivity`), with so many
/// rotations: an array of {mesh, builder, quality, rows: [{change, cases, largest_change, same_spheres}]}; `error` in place of rows where
/// no tree can be built. Like runs, what `folder` holds is not done again.
/// @throws builder::Cancelled, formats::FileError.
Json compareStability(const std::vector<ComparedMesh>& meshes, const std::vector<Method>& what, const builder::BuildSettings& settings,
                      int rotations, const std::filesystem::path& folder, builder::Progress& progress);

/// One line for each level of each run.
std::string comparisonCsv(const Json& comparison);

}  // namespace spheretree::tool
