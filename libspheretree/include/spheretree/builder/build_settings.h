// SPDX-License-Identifier: GPL-3.0-or-later
// The settings of a build: the builder, the shape of the tree, and how much work to spend.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace spheretree::builder {

enum class BuilderKind { Cover, Combined, Merge, Burst, Expand, Spawn, Grid, Hubbard, Octree };
enum class Quality { Quick, Standard, Best };
enum class MedialAxis { Adaptive, Static };

std::string_view name(BuilderKind kind);
std::string_view name(Quality quality);
std::string_view name(MedialAxis axis);

inline constexpr double kSkinTolerance = 2e-3;  // default tolerance of the skin, as a share of the diagonal

struct BuildSettings {
  BuilderKind builder = BuilderKind::Cover;
  std::vector<BuilderKind> combine;  // the builders that Combined chooses from
  bool search = false;               // the cover search distributes the balls of a published builder; builder Cover always searches
  MedialAxis medial_axis = MedialAxis::Adaptive;  // of Merge, Burst, Expand and Combined; Hubbard's is static
  int levels = 4;                                 // range [2, 6]; the root is level 0
  int branching = 8;                              // range [2, 8]
  Quality quality = Quality::Standard;
  int max_leaves = 0;       // 1 .. 32768: at most this number of leaves; 0: branching^(levels - 1). Builders that search only
  double tolerance_mm = 0;  // > 0: the smallest number of spheres whose leaf overhang stays within this; 0: all spheres
  // Tolerance of each triangle, >= tolerance_mm > 0; empty: tolerance_mm everywhere. A leaf may then reach out as far
  // as the triangle through which it leaves the object allows (graded_tolerance.h). Builders that search only.
  std::vector<double> tolerance_of_triangle_mm;
  // > 0: leaves for soft tissue (docs/tissue.md). A leaf's radius is at most this share of the radius of the largest
  // ball that touches the surface where the leaf does; range [0, 0.5]. Builder Cover only.
  double soft_share = 0;
  bool skin = true;              // store the surface that a tool rests on; docs/algorithms/skin/skin.md
  double skin_tolerance_mm = 0;  // > 0: largest distance of the skin from the mesh; 0: tolerance_mm, or kSkinTolerance of the diagonal
  double crease_angle_deg = 50;  // edges of the mesh with a larger angle stay sharp on the skin; range [1, 180]
  bool hulls = false;            // store convex hulls of balls beside the balls, for a tool; docs/algorithms/hulls/fit_hulls.md
  double hull_tolerance_mm = 0;  // > 0: the fewest hulls whose overhang stays within this; 0: the tightest max_hulls
  int max_hulls = 256;           // at most this number of hulls, range [1, 4096]; if the tolerance needs more, the tree has none
  bool simplify = true;          // search on fewer triangles if the mesh is finer than the spheres can follow (simplify_mesh.h)
  double unit_mm = 1;            // unit of the source file [mm]; only recorded
  std::uint64_t seed = 1;        // any value
  int threads = 0;               // 0: all processors of the machine; the result does not depend on it

  bool searches() const { return search || builder == BuilderKind::Cover; }
};

/// @throws std::invalid_argument for settings out of range; the message names the setting and its range.
void validate(const BuildSettings& settings);

/// The mesh was refused, or no tree can be built for it.
struct BuildError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace spheretree::builder
