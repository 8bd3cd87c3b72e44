// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/octree_cells.h"

#include <algorithm>
#include <array>
#include <utility>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

// Both parts get exactly the same corner on the plane.
std::array<Polygon, 2> cut(const Polygon& piece, int axis, double at) {
  std::array<Polygon, 2> parts;
  for (std::size_t i = 0; i < piece.size(); ++i) {
    const Vector3d &a = piece[i], &b = piece[(i + 1) % piece.size()];
    const double da = a[axis] - at, db = b[axis] - at;
    if (da <= 0) parts[0].push_back(a);
    if (da >= 0) parts[1].push_back(a);
    if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
      Vector3d p = a + (da / (da - db)) * (b - a);
      p[axis] = at;
      parts[0].push_back(p);
      parts[1].push_back(p);
    }
  }
  // A piece that only touches the plane belongs only to the other side.
  for (Polygon& part : parts)
    if (part.size() < 3) part.clear();
  return parts;
}

}  // namespace

OctreeCell rootCell(const TriangleMesh& mesh, const DistanceField& field) {
  OctreeCell root;
  const Vector3d half = Vector3d::Constant(0.5 * field.box().sizes().maxCoeff());
  root.box = Eigen::AlignedBox3d(field.box().center() - half, field.box().center() + half);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) root.pieces.push_back({mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)});
  return root;
}

std::vector<OctreeCell> halve(const OctreeCell& whole, int axis) {
  const double middle = whole.box.center()[axis];
  std::array<OctreeCell, 2> half;
  half[0].box = half[1].box = whole.box;
  half[0].box.max()[axis] = half[1].box.min()[axis] = middle;
  for (const Polygon& piece : whole.pieces) {
    std::array<Polygon, 2> parts = cut(piece, axis, middle);
    // A flat piece in the plane itself would otherwise belong to both.
    if (!parts[0].empty() && !parts[1].empty() &&
        std::all_of(piece.begin(), piece.end(), [&](const Vector3d& p) { return p[axis] == middle; }))
      parts[1].clear();
    for (std::size_t s = 0; s < 2; ++s)
      if (!parts[s].empty()) half[s].pieces.push_back(std::move(parts[s]));
  }
  std::vector<OctreeCell> halves;
  for (OctreeCell& h : half)
    if (!h.pieces.empty()) halves.push_back(std::move(h));
  return halves;
}

}  // namespace spheretree::builder
