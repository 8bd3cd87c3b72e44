// SPDX-License-Identifier: GPL-3.0-or-later
// The figures of an evaluated sphere-tree, level by level. Definitions, methods and accuracy of each figure:
// docs/measures.md
// Units: mm, frame of the mesh.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace spheretree::builder {

struct Overhang {
  double max = 0;    // largest found, at `worst_point` [mm]
  double bound = 0;  // no point of the boundary has a larger overhang; >= max [mm]
  double p99 = 0;    // 99th percentile and mean over the part of the boundary that is outside, by area [mm]
  double mean = 0;
  double outside_area = 0;  // of the union's boundary [mm^2]
  Eigen::Vector3d worst_point = Eigen::Vector3d::Zero();
  std::optional<std::uint32_t> worst_ball;  // index into the balls measured; none if nothing is outside
};

struct Coverage {
  double uncovered_fraction = 0;  // share of the area, estimated from the samples
  double max_gap = 0;             // 0 if none above the tolerance was found; infinite for a union of no balls [mm]
  double max_gap_bound = 0;       // proven: no gap is larger; normally at most max(max_gap, tolerance) + tolerance / 2 [mm]
  Eigen::Vector3d worst_point = Eigen::Vector3d::Zero();
};

struct CoverLimits {
  double h_fin = 0;            // overhang of the best cover if the surface were flat compared with the balls [mm]
  double h_low = 0;            // approximate lower limit without that assumption; see h_low_in_range [mm]
  bool h_low_in_range = true;  // false: h_low is only the end of the range searched, 5e-5 to 0.3 of the diagonal, or 0
};

/// Proven (docs/algorithms/measure/lower_bound.md); `overhang` is 0 if nothing was proven.
struct ProvenLimit {
  double overhang = 0;  // no cover of that many spheres has a smaller overhang [mm]
  double spheres = 0;   // with that overhang, no fewer spheres than this cover the surface
};

struct LevelEvaluation {
  int level = 0;
  std::size_t spheres = 0;  // in the level set: the nodes of the level and the leaves of earlier levels
  Overhang overhang;
  Coverage coverage;
  double excess_volume_fraction = 0;   // of the union outside the mesh, over the mesh's volume
  double missing_volume_fraction = 0;  // of the mesh outside the union, over the mesh's volume
};

struct HierarchyEvaluation {
  std::size_t leaves = 0;
  std::size_t leaves_outside_ancestor = 0;        // leaves whose cover sphere is not inside the bounding sphere of every ancestor
  std::size_t leaves_outside_ancestor_cover = 0;  // leaves whose cover sphere is not inside the cover sphere of every ancestor: harmless
                                                  // here, a fault in a tree with one sphere a node
};

/// Of the surface that a tool rests on (core's skin.h).
struct SkinEvaluation {
  std::size_t triangles = 0, vertices = 0, edges = 0;
  std::size_t sharp_edges = 0;     // a sharp edge between two triangles counts for each of them
  std::size_t flat_triangles = 0;  // whose patch is flat, with one normal
  std::size_t bytes = 0;           // in the file
  double tolerance = 0;            // stated in the tree: no point of a patch is farther than this from its flat triangle [mm]
  double mesh_distance = 0;        // stated in the tree: two-sided distance of the flat triangles and the mesh is at most this [mm]
  double crease_angle = 0;         // [rad]
  double edge_angle_median = 0, edge_angle_p99 = 0, edge_angle_max = 0;  // between flat triangles, over the edges that are not sharp [rad]
  std::optional<double> from_mesh,
      of_mesh;  // measured upper bounds: distance of the flat triangles from the mesh, and of the mesh from them [mm]; only with effort 1
};

/// Of the hulls of a tool (core's hulls.h), which stand for it beside the balls.
struct HullEvaluation {
  std::size_t hulls = 0, parts = 0, balls = 0;
  double overhang_max = 0;                    // largest that some ball between those of a part has [mm]
  double overhang_bound = 0;                  // stated in the tree: no point of a hull is farther outside the mesh [mm]
  std::size_t samples = 0, bare_samples = 0;  // of the surface, and those that no part holds
  double max_gap = 0;                         // largest distance of a bare sample from the hulls [mm]
};

struct Evaluation {
  double diagonal = 0;   // of the bounding box of the mesh and its sheets (surface_with_sheets.h) [mm]
  double tolerance = 0;  // of coverage and enclosure: 1e-5 of the diagonal [mm]
  std::vector<LevelEvaluation> levels;
  HierarchyEvaluation hierarchy;
  std::optional<CoverLimits> limits;   // of the deepest level
  std::optional<ProvenLimit> proven;   // of the deepest level, if asked for
  std::optional<SkinEvaluation> skin;  // of a tree that has one
  std::optional<HullEvaluation> hulls;
};

}  // namespace spheretree::builder
