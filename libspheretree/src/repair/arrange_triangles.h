// SPDX-License-Identifier: GPL-3.0-or-later
// The arrangement of a mesh whose triangles cross: pieces of triangles that meet only in corners and edges.
//
// Paper: Q. Zhou, E. Grinspun, D. Zorin, A. Jacobson. Mesh arrangements for solid geometry. ACM TOG 35(4), 2016. The
// cuts are exact (cut_points.h), and the new corners are rounded to double at the end.
// Units: mm. Deterministic.
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "repair/repair_work.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// Triangles with the same corners count as one facet.
struct Arrangement {
  struct Member {
    std::uint32_t triangle;  // of the mesh
    int winding;             // +1: like the facet, -1: opposite
  };
  std::vector<Triangle> facets;
  std::vector<std::uint32_t> first_member;  // for each facet: index in `members`; then their number
  std::vector<Member> members;
  std::vector<Eigen::Vector3d> positions;  // those of the mesh, then the new ones

  std::span<const Member> membersOf(std::size_t f) const {
    return {members.data() + first_member[f], members.data() + first_member[f + 1]};
  }
  /// Difference of the winding numbers behind and in front of a facet.
  int net(std::size_t f) const;
  double area(std::size_t f) const;
};

/// `pairs`: the pairs of triangles that cross (crossing_triangles.h); no triangle may be flat. Empty if there would be
/// more than `max_pieces`: a triangle with n points in it, its corners included, has at most 2 n - 5 pieces, so that
/// this is known before the triangle is divided.
/// Cost: about 20 us for a pair, for a point and for a cut in a triangle; asks for an interrupt before each of them.
/// @throws Cancelled, TooMuchWork
std::optional<Arrangement> arrangeTriangles(const TriangleMesh& mesh, std::span<const std::pair<std::uint32_t, std::uint32_t>> pairs,
                                            std::size_t max_pieces, Progress& progress, RepairWork& work);

}  // namespace spheretree::builder
