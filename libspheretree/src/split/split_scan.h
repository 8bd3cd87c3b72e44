// SPDX-License-Identifier: GPL-3.0-or-later
// Splits a labelled intraoral scan, which is one open surface of gum and crowns, into closed solids: one for each
// tooth, one for the gum. The solids fill the space below the scan without gap or overlap: neighbours share the walls
// between them, and the caps of the teeth are the floors of the sockets in the gum. Steps and guarantees: docs/split.md
// Units: mm. Deterministic: same scan, same solids, for any number of threads.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"
#include "split/untangle_scan.h"

namespace spheretree::builder {

struct SplitSettings {
  double smooth_mm = 0.15;                 // >= 0: largest motion of the border between labels when it is smoothed
  double min_area_mm2 = 4;                 // >= 0: smaller pieces of a label join the neighbour with the longest common border
  double base_mm = 4;                      // > 0: distance from the lowest point of the scan to the base plane of the gum
  double root_mm = 0;                      // >= 0: length of the conical stub of a tooth; 0: a cap of least bending
  std::optional<Eigen::Vector3d> up = {};  // from the gum to the biting edges, not zero; empty: as the scan tells
};

inline constexpr std::int32_t kGumLabel = 0;

/// A solid. Its triangles are those of the scan, cut along the border of its label, or invented.
struct SplitPart {
  std::int32_t label = kGumLabel;
  int piece = 1;  // a label with several pieces gives several solids; the largest is piece 1
  TriangleMesh mesh;
  std::vector<char> is_invented;      // for each triangle: not part of the scan; empty if the repair changed the mesh
  double scanned_area = 0;            // [mm^2]
  double invented_area = 0;           // area of caps, walls, base and hole fillings [mm^2]
  double rim_length = 0;              // length of the border of the label on the scan [mm]; of the gum: of its borders with teeth
  double volume = 0;                  // [mm^3]
  bool is_sound = false;              // closed, manifold, wound outward, without self-intersections
  Eigen::Vector3d fault{0, 0, 0};     // a place where it is not sound [mm]
  std::size_t crossing_pairs = 0;     // crossing pairs of triangles, one of this part and one of another; exact
  Eigen::Vector3d crossing{0, 0, 0};  // place of one of these crossings [mm]
  std::vector<std::string> notes;     // whole sentences
};

struct SplitScan {
  std::vector<SplitPart> parts;    // by label, then piece; the gum last
  Eigen::Vector3d up{0, 0, 0};     // unit vector from the gum to the biting edges
  double scan_area = 0;            // of the given scan [mm^2]
  double lost_area = 0;            // area of the scan in no part: debris, double layers, crossing triangles [mm^2]
  MovedVertices moved;             // where the scan crossed itself
  std::size_t crossing_pairs = 0;  // crossing pairs of triangles of different parts; exact
  std::size_t holes = 0;           // number of filled holes of the scan
  std::vector<std::string> notes;  // whole sentences
};

/// `label_of_vertex`: one for each vertex of `scan`, >= 0; kGumLabel is gum.
/// Cost: O(n log n), about 10 s for 300,000 vertices.
/// @throws std::invalid_argument for a number of labels other than that of the vertices, or a negative one;
/// BuildError if nothing can be split: no label but gum, or no surface; Cancelled.
SplitScan splitScan(const TriangleMesh& scan, std::span<const std::int32_t> label_of_vertex, const SplitSettings& settings,
                    Progress& progress);

}  // namespace spheretree::builder
