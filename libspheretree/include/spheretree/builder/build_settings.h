// SPDX-License-Identifier: GPL-3.0-or-later
// What a build is asked for: the builder, the shape of the tree, and how much work to spend.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string_view>
#include <vector>

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
  // Of each triangle, >= tolerance_mm > 0; empty: tolerance_mm everywhere. Then a leaf may reach out by as much as the
  // place allows where it leaves the object (graded_tolerance.h). Builder Cover only.
  std::vector<double> tolerance_of_triangle_mm;
  // > 0: leaves for soft tissue, with at most this share of the radius of the largest ball that touches the surface
  // where they do (docs/tissue.md); range [0, 0.5]. Builder Cover only.
  double soft_share = 0;
  bool skin = true;              // store the surface that a tool is to rest on; docs/algorithms/skin/skin.md
  double skin_tolerance_mm = 0;  // > 0: the skin lies within this of the mesh; 0: tolerance_mm, or 0.2 % of the diagonal
  double crease_angle_deg = 50;  // edges of the mesh that bend more stay sharp on the skin; range [1, 180]
  bool simplify = true;          // search on fewer triangles where the mesh has more than the spheres can follow (simplify_mesh.h)
  double unit_mm = 1;            // only recorded: unit of the source file [mm]
  std::uint64_t seed = 1;        // any value
  int threads = 0;               // 0: as many as the machine has; the result does not depend on it
};

/// @throws std::invalid_argument, with the setting and its range, for settings out of range.
void validate(const BuildSettings& settings);

/// The mesh was refused, or no tree can be built for it.
struct BuildError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace spheretree::builder
