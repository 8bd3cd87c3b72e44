// SPDX-License-Identifier: GPL-3.0-or-later
// A labelled intraoral scan, one open surface of gum and crowns, as closed solids: one for each tooth, one for the gum.
// The solids fill the space under the scan without gap or overlap: neighbours share the walls between them, and the gum
// has the caps of the teeth as floors of its sockets. Steps and what each guarantees: docs/split.md
// Units: mm. Deterministic: same scan, same solids, for any number of threads.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct SplitSettings {
  double smooth_mm = 0.15;  // >= 0: how far the border between labels may be moved to make it smooth
  double min_area_mm2 = 4;  // >= 0: smaller pieces of a label join the neighbour with the longest common border
  double base_mm = 4;       // > 0: from the lowest point of the scan to the base plane of the gum
  double root_mm = 0;       // >= 0: length of the conical stub of a tooth; 0: a cap that bends least
};

inline constexpr std::int32_t kGumLabel = 0;

/// A solid. Its triangles are the scan's, cut along the border of its label, or invented.
struct SplitPart {
  std::int32_t label = kGumLabel;
  int piece = 1;  // a label in several pieces gives several solids, the largest is 1
  TriangleMesh mesh;
  std::vector<char> is_invented;      // for each triangle: no part of the scan; empty if the repair changed the mesh
  double scanned_area = 0;            // [mm^2]
  double invented_area = 0;           // [mm^2] caps, walls, base and fillings of holes
  double rim_length = 0;              // of the border of the label on the scan [mm]; of the gum: of its borders with teeth
  double volume = 0;                  // [mm^3]
  bool is_sound = false;              // closed, manifold, wound outward, without crossings
  Eigen::Vector3d fault{0, 0, 0};     // a place where it is not sound [mm]
  std::size_t crossing_pairs = 0;     // of triangles, one of them of another part, that cross; exact
  Eigen::Vector3d crossing{0, 0, 0};  // a place where one does [mm]
  std::vector<std::string> notes;     // whole sentences
};

struct SplitScan {
  std::vector<SplitPart> parts;    // by label, then piece; the gum last
  Eigen::Vector3d up{0, 0, 0};     // unit vector out of the gum to the biting edges
  double scan_area = 0;            // of the scan as it was given [mm^2]
  double lost_area = 0;            // of it, in no part: debris, double layers [mm^2]
  std::size_t crossing_pairs = 0;  // of triangles of different parts that cross; exact
  std::size_t holes = 0;           // of the scan, that were filled
  std::vector<std::string> notes;  // whole sentences
};

/// `label_of_vertex`: one for each vertex of `scan`, >= 0; kGumLabel is gum.
/// Cost: O(n log n), about 10 s for 300,000 vertices.
/// @throws std::invalid_argument for a number of labels other than that of the vertices, or a negative one;
/// BuildError if nothing can be split: no label but gum, or no surface; Cancelled.
SplitScan splitScan(const TriangleMesh& scan, std::span<const std::int32_t> label_of_vertex, const SplitSettings& settings,
                    Progress& progress);

}  // namespace spheretree::builder
