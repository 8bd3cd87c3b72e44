// SPDX-License-Identifier: GPL-3.0-or-later
// The entry of the offline side: mesh and settings in, certified sphere-tree and statistics out.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "spheretree/builder/progress.h"
#include "spheretree/core/sphere_tree.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

enum class BuilderKind { Cover, Combined, Merge, Burst, Expand, Spawn, Grid, Hubbard, Octree };
enum class Quality { Quick, Standard, Best };

std::string_view name(BuilderKind kind);
std::string_view name(Quality quality);

struct BuildSettings {
  BuilderKind builder = BuilderKind::Cover;
  std::vector<BuilderKind> combine;  // members of Combined
  int levels = 4;                    // range [2, 6]; the root is level 0
  int branching = 8;                 // range [2, 8]
  Quality quality = Quality::Standard;
  int most_leaves = 0;      // > 0: no more leaves than this; 0: branching^(levels - 1). Builder Cover only
  double tolerance_mm = 0;  // > 0: fewest spheres whose worst leaf overhang stays within; 0: the whole budget
  // Of each triangle, >= tolerance_mm > 0; empty: tolerance_mm everywhere. Then a leaf may reach out by as much as the place allows where
  // it leaves the object (graded_tolerance.h). Builder Cover only.
  std::vector<double> tolerance_of_triangle_mm;
  bool simplify = true;    // search on fewer triangles where the mesh has more than the spheres can follow (simplify_mesh.h)
  double unit_mm = 1;      // only recorded: unit of the source file [mm]
  std::uint64_t seed = 1;  // any value
  int threads = 0;         // 0: as many as the machine has; the result does not depend on it
};

struct LevelBuildStatistics {
  std::size_t spheres = 0;
  double overhang_bound_mm = 0;  // proven
  double largest_growth_mm = 0;  // by certification
};

/// Of the mesh that the search ran on. What is stated of the tree is proven against the mesh given, whatever the search ran on.
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

/// The mesh was refused, or no tree can be built for it.
struct BuildError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Builds, certifies and wraps. The mesh must have passed checkMesh (mesh_checks.h): closed, oriented outward, manifold, free
/// of self-intersections, or come from repairMesh (repair_mesh.h). `cover_too`: triangles that every level covers as well, of any
/// kind; where they reach out of the solid they are part of the surface that overhang is measured from. Same mesh and settings (threads
/// aside): same bytes.
/// @throws BuildError, Cancelled, std::invalid_argument for settings out of range.
BuildResult buildSphereTree(const TriangleMesh& mesh, const BuildSettings& settings, Progress& progress,
                            const TriangleMesh& cover_too = {});

}  // namespace spheretree::builder
