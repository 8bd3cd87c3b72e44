// SPDX-License-Identifier: GPL-3.0-or-later
// The entry of the offline side: mesh and settings in, certified sphere-tree and statistics out.
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
  double overhang_bound_mm = 0;  // proven
  double largest_growth_mm = 0;  // by certification
};

/// Of the mesh that the search ran on. What is stated of the tree is proven against the mesh given, whatever the search
/// ran on.
struct Simplification {
  std::size_t triangles = 0;     // 0: the search ran on the mesh given
  double distance_bound_mm = 0;  // proven: no point of the mesh given is farther from the simplified surface
};

struct BuildStatistics {
  Simplification simplification;
  std::vector<LevelBuildStatistics> levels;
  std::size_t certified_pieces = 0;
  bool tolerance_met = true;
  double least_tolerance_mm = 0;  // the least tolerance_mm that the leaves meet; those of triangles beyond it by as much as given
  struct Stage {
    std::string name;
    double seconds;
  };
  std::vector<Stage> stages;
};

struct BuildResult {
  SphereTree tree;
  BuildStatistics statistics;
};

/// Builds, certifies and wraps. The mesh must have passed checkMesh (mesh_checks.h): closed, oriented outward,
/// manifold, free of self-intersections, or come from repairMesh (repair_mesh.h). `cover_too`: triangles that every
/// level covers as well, of any kind; where they reach out of the solid they are part of the surface that overhang is
/// measured from. Same mesh and settings (threads aside): same bytes.
/// @throws BuildError, Cancelled, std::invalid_argument for settings out of range.
BuildResult buildSphereTree(const TriangleMesh& mesh, const BuildSettings& settings, Progress& progress,
                            const TriangleMesh& cover_too = {});

}  // namespace spheretree::builder
