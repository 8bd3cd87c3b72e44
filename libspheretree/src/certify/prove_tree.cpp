// SPDX-License-Identifier: GPL-3.0-or-later
#include "certify/prove_tree.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <vector>

#include "certify/overhang_bound.h"
#include "certify/power_cells.h"
#include "certify/triangle_piece.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

// Halves the triangle to pieces that few balls touch, because the cells of n balls take n^2 operations. `before`: the
// balls that hold the last triangle or its last piece, which is often a neighbour.
bool isHeld(PowerCells& cells, const Piece& triangle, double longest, std::vector<std::uint32_t>& before, std::vector<Piece>& open) {
  if (cells.suffice(triangle.corner, before)) return true;
  open.assign(1, triangle);
  while (!open.empty()) {
    const Piece piece = open.back();
    open.pop_back();
    if (radiusAbout(piece, centroidOf(piece)) > longest) {
      for (const Piece& half : halvesOf(piece, longestSide(piece))) open.push_back(half);
    } else if (!cells.holes(piece.corner, [](const Vector3d&, std::uint32_t) {})) {
      return false;
    } else {
      before.assign(cells.heldBy().begin(), cells.heldBy().end());
    }
  }
  return true;
}

}  // namespace

bool provenCovered(const TriangleMesh& mesh, std::span<const Sphere> spheres, const Vector3d& origin, Progress& progress) {
  // Half of the margin that certifyCover() leaves: both proofs round, and this one may not doubt what that one has
  // proven.
  const double margin = 0.5 * roundingMargin(mesh, origin);
  std::vector<Ball> balls;
  double longest = margin;  // of the pieces: the mean radius
  for (const Sphere& s : spheres) {
    balls.push_back({Vector3d(double{s.x}, double{s.y}, double{s.z}), double{s.radius}});
    longest += double{s.radius} / static_cast<double>(spheres.size());
  }
  const BallIndex index(balls, -margin);
  const std::size_t triangles = mesh.triangles.size();
  std::atomic<bool> covered = true;
  tbb::parallel_for(std::size_t{0}, (triangles + kTrianglesAChunk - 1) / kTrianglesAChunk, [&](std::size_t chunk) {
    progress.check();
    PowerCells cells(index);
    std::vector<std::uint32_t> before;
    std::vector<Piece> open;
    for (std::size_t t = chunk * kTrianglesAChunk; covered && t < std::min(triangles, (chunk + 1) * kTrianglesAChunk); ++t)
      if (!isHeld(cells, pieceOf(mesh, t, origin), longest, before, open)) covered = false;
  });
  return covered;
}

std::string findUnproven(const TriangleMesh& mesh, const DistanceField& field, const SphereTree& decoded, Progress& progress) {
  const Vector3d origin(decoded.origin_mm[0], decoded.origin_mm[1], decoded.origin_mm[2]);
  std::vector<double> overhang;
  for (const Sphere& s : decoded.cover) overhang.push_back(overhangBound(field, origin, s));
  for (int level = 0; level < decoded.levelCount(); ++level) {
    std::vector<Sphere> spheres;
    for (const std::uint32_t node : levelSet(decoded, level)) {
      spheres.push_back(decoded.cover[node]);
      if (overhang[node] > double{decoded.statistics[static_cast<std::size_t>(level)].overhang_bound})
        return "level " + std::to_string(level) + ": node " + std::to_string(node) + " reaches out by more than the bound of its level";
    }
    if (!provenCovered(mesh, spheres, origin, progress)) return "level " + std::to_string(level) + " does not provably cover the surface";
  }
  return {};
}

}  // namespace spheretree::builder
