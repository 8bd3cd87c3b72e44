// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/hull_cover.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kRoundings = 10;  // of the split points, and of the closed forms

std::vector<Eigen::AlignedBox3d> boxesOf(std::span<const Hull> hulls) {
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const Hull& hull : hulls) boxes.push_back(boxOf(hull));
  return boxes;
}

}  // namespace

HullCover::HullCover(std::span<const Hull> hulls, double margin) : tree_(boxesOf(hulls), 2), margin_(margin) {
  for (const std::uint32_t i : tree_.order()) distance_.emplace_back(hulls[i]);
}

bool HullCover::holds(const Piece& triangle, std::size_t omitted, Vector3d* bare) const {
  struct Frame {
    Piece piece;
    std::size_t begin, end;  // of its hulls in the stack `near`
  };
  std::vector<std::uint32_t> near;
  const Vector3d middle = centroidOf(triangle);
  const double extent = radiusAbout(triangle, middle);
  tree_.searchWithin(middle, extent * extent * (1 + kRounding), [&](std::size_t first, std::size_t count) {
    for (std::size_t slot = first; slot < first + count; ++slot)
      if (tree_.order()[slot] != omitted) near.push_back(static_cast<std::uint32_t>(slot));
  });
  std::vector<Frame> open{{triangle, 0, near.size()}};
  while (!open.empty()) {
    const Frame frame = open.back();
    open.pop_back();
    near.resize(frame.end);
    const Vector3d centroid = centroidOf(frame.piece);
    const double reach = radiusAbout(frame.piece, centroid);
    bool is_held = false, is_middle_held = false;
    for (std::size_t i = frame.begin; i < frame.end && !is_held; ++i) {
      const std::uint32_t slot = near[i];
      const HullDistance& distance = distance_[slot];
      const double at = distance(centroid);
      if (at > reach) continue;
      near.push_back(slot);
      if (at > -margin_) continue;
      is_middle_held = true;
      is_held = std::ranges::all_of(frame.piece.corner, [&](const Vector3d& p) { return distance(p) <= -margin_; });
    }
    if (is_held) continue;
    if (!is_middle_held || reach < margin_) {
      if (bare) *bare = centroid;
      return false;
    }
    const std::size_t end = near.size();
    for (const Piece& half : halvesOf(frame.piece, longestSide(frame.piece))) open.push_back({half, frame.end, end});
  }
  return true;
}

bool provenCovered(const TriangleMesh& mesh, std::span<const Hull> hulls, const Vector3d& origin, Progress& progress) {
  const HullCover cover(hulls, kRoundings * roundingMargin(mesh, origin));
  std::atomic<bool> covered = true;
  tbb::parallel_for(std::size_t{0}, mesh.triangles.size(), [&](std::size_t t) {
    progress.check();
    if (covered && !cover.holds(pieceOf(mesh, t, origin))) covered = false;
  });
  return covered;
}

}  // namespace spheretree::builder
