// SPDX-License-Identifier: GPL-3.0-or-later
// Entry point of the builder: mesh and settings in, certified sphere-tree and statistics out.
#pragma once

#include <string>
#include <vector>

#include "spheretree/builder/build_settings.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/sphere_tree.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct LevelBuildStatistics {
  std::size_t spheres = 0;
  double overhang_bound_mm = 0;  // proven overhang bound
  double largest_growth_mm = 0;  // largest increase of a radius by certification
};

/// The simplified mesh that the search ran on. All statements about the tree are proven against the original mesh, not
/// against this one.
struct Simplification {
  std::size_t triangles = 0;     // 0: the search ran on the original mesh
  double distance_bound_mm = 0;  // proven: no point of the original mesh is farther from the simplified surface
};

struct BuildStatistics {
  Simplification simplification;
  std::vector<LevelBuildStatistics> levels;
  std::size_t certified_pieces = 0;
  bool tolerance_met = true;
  double min_tolerance_mm = 0;  // the smallest tolerance_mm that the leaves meet; tolerances of triangles keep their difference to it
  struct Stage {
    std::string name;
    double seconds;
  };
  std::vector<Stage> stages;       // one after the other; of the skin, which is made beside the balls, the rest after them
  std::vector<std::string> notes;  // what was left out, and why; whole sentences
};

struct BuildResult {
  SphereTree tree;
  BuildStatistics statistics;
  SphereTree uncertified;  // of a published builder that does not search: as its method makes it, before certification
};

/// Builds the tree, certifies it and computes its bounding spheres. The mesh must have passed checkMesh
/// (mesh_checks.h): closed, oriented outward, manifold, free of self-intersections; or it must come from repairMesh
/// (repair_mesh.h). `cover_too`: further triangles, of any kind, that every level covers as well. Where they lie
/// outside the solid, they are part of the surface from which overhang is measured. Same mesh and settings (except
/// `threads`): same bytes.
/// @throws BuildError, Cancelled, std::invalid_argument for settings out of range.
BuildResult buildSphereTree(const TriangleMesh& mesh, const BuildSettings& settings, Progress& progress,
                            const TriangleMesh& cover_too = {});

}  // namespace spheretree::builder
